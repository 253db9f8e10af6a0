// The body of this folder for the modal module of Chrono 9, as `vademecum export craig-bampton` has written it.
//
//     chrono::ChSystemNSC system;
//     vademecum::ModalBody rod = vademecum::add_modal_body(system, "rod", 12);
//     auto pin = chrono_types::make_shared<chrono::ChLinkMateRevolute>();
//     pin->Initialize(rod.frame("x_min"), crank, chrono::ChFrame<>(...));
//
// The interfaces are the boundary nodes of a ChModalAssembly; mass and stiffness over them and over the nodes inside come
// from chrono_mass.mtx and chrono_stiffness.mtx, and Chrono reduces them by its own Craig–Bampton or Herting method.
// Boundary nodes have no mass of their own, so gravity acts on no node: it is a force of the program that uses them.
//
// Written from the documented interface of Chrono (ChModalAssembly::DoModalReduction with matrices of other programs).

#pragma once

#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "chrono/fea/ChMesh.h"
#include "chrono/fea/ChNodeFEAxyz.h"
#include "chrono/fea/ChNodeFEAxyzrot.h"
#include "chrono/physics/ChSystem.h"
#include "chrono_modal/ChModalAssembly.h"
#include "chrono_modal/ChModalDamping.h"
#include "chrono_modal/ChModalSolverUndamped.h"
#include "chrono_modal/ChUnsymGenEigenvalueSolver.h"

namespace vademecum {

/// An assembly and its boundary nodes, by the name of the interface.
struct ModalBody {
    std::shared_ptr<chrono::modal::ChModalAssembly> assembly;
    std::map<std::string, std::vector<std::shared_ptr<chrono::fea::ChNodeFEAxyz>>> nodes;
    std::map<std::string, std::shared_ptr<chrono::fea::ChNodeFEAxyzrot>> frames;

    /// The node of a frame.
    std::shared_ptr<chrono::fea::ChNodeFEAxyzrot> frame(const std::string& name) const {
        auto found = frames.find(name);
        if (found == frames.end()) throw std::runtime_error("no interface `" + name + "` that is a frame");
        return found->second;
    }
};

/// A symmetric matrix of Matrix Market's coordinate form, of which the file has the lower triangle.
inline chrono::ChSparseMatrix read_market(const std::string& path) {
    std::ifstream file(path);
    std::string line;
    if (!std::getline(file, line) || line != "%%MatrixMarket matrix coordinate real symmetric")
        throw std::runtime_error(path + ": expected a symmetric Matrix Market file of coordinates");
    int rows = 0, columns = 0, count = 0;
    file >> rows >> columns >> count;
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(2 * static_cast<size_t>(count));
    for (int k = 0; k < count; ++k) {
        int row = 0, column = 0;
        double value = 0;
        if (!(file >> row >> column >> value)) throw std::runtime_error(path + ": fewer entries than its header says");
        entries.emplace_back(row - 1, column - 1, value);
        if (row != column) entries.emplace_back(column - 1, row - 1, value);
    }
    chrono::ChSparseMatrix matrix(rows, columns);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

/// Adds the body of a folder to a system and reduces it to so many modes.
inline ModalBody add_modal_body(
    chrono::ChSystem& system,
    const std::string& folder,
    unsigned modes,
    chrono::modal::ChModalAssembly::ReductionType type = chrono::modal::ChModalAssembly::ReductionType::CRAIG_BAMPTON,
    double alpha = 0,
    double beta = 0) {
    using namespace chrono;
    ModalBody body;
    body.assembly = chrono_types::make_shared<modal::ChModalAssembly>();
    body.assembly->SetReductionType(type);
    body.assembly->SetModalAutomaticGravity(false);
    body.assembly->SetInternalNodesUpdate(false);
    system.Add(body.assembly);
    auto boundary = chrono_types::make_shared<fea::ChMesh>();
    boundary->SetAutomaticGravity(false);
    body.assembly->Add(boundary);
    // Rows of the table: kind, x, y, z, interface; in the order of the rows of the matrices.
    std::ifstream table(folder + "/chrono_boundary.csv");
    std::string line;
    if (!std::getline(table, line) || line != "kind,x,y,z,interface")
        throw std::runtime_error(folder + "/chrono_boundary.csv: expected the table of boundary nodes");
    while (std::getline(table, line)) {
        std::istringstream cells(line);
        std::string kind, x, y, z, name;
        std::getline(cells, kind, ',');
        std::getline(cells, x, ',');
        std::getline(cells, y, ',');
        std::getline(cells, z, ',');
        std::getline(cells, name);
        ChVector3d at(std::stod(x), std::stod(y), std::stod(z));
        if (kind == "frame") {
            auto node = chrono_types::make_shared<fea::ChNodeFEAxyzrot>(ChFrame<>(at));
            node->SetMass(0);
            node->GetInertia().setZero();
            boundary->AddNode(node);
            body.frames[name] = node;
        } else {
            auto node = chrono_types::make_shared<fea::ChNodeFEAxyz>(at);
            node->SetMass(0);
            boundary->AddNode(node);
            body.nodes[name].push_back(node);
        }
    }
    ChSparseMatrix mass = read_market(folder + "/chrono_mass.mtx");
    ChSparseMatrix stiffness = read_market(folder + "/chrono_stiffness.mtx");
    ChSparseMatrix constraints(0, mass.cols());
    auto eigensolver = chrono_types::make_shared<modal::ChUnsymGenEigenvalueSolverKrylovSchur>();
    modal::ChModalSolverUndamped<modal::ChUnsymGenEigenvalueSolverKrylovSchur> solver(modes, 1e-5, true, false, eigensolver);
    body.assembly->DoModalReduction(mass, stiffness, constraints, solver, modal::ChModalDampingRayleigh(alpha, beta));
    return body;
}

}  // namespace vademecum
