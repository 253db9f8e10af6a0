// Every function of the header of C++, and bodies and batches that are moved; compiled with sanitizers. Takes files with stress,
// with reactions, of a free body, with live parameters, with the factor of the stiffness, of a moving base, and of a world.
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "vademecum.hpp"

using namespace vademecum;

static void check(bool holds, const char *what) {
    if (!holds) {
        std::fprintf(stderr, "%s\n", what);
        std::exit(1);
    }
}

template <typename Call> static void refused(Call call, const char *words) {
    try {
        call();
    } catch (const Error &error) {
        check(std::string(error.what()).find(words) != std::string::npos, error.what());
        return;
    }
    check(false, words);
}

static Body pushed(const char *path) {
    Body body(File::read(path));
    body.push(body.at_node(body.needs().load_nodes - 1), {1, -2, -20});
    body.step();
    return body;
}

static void stress(Body body) {
    check(body.stress_points() > 0 && body.stress_point(0)[0] < body.needs().nodes, "stress points");
    const Tensor s = body.stress(0), e = body.strain(0);
    const double apart = std::pow(s[0] - s[1], 2) + std::pow(s[1] - s[2], 2) + std::pow(s[2] - s[0], 2);
    const double shear = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    const double expected = std::sqrt(0.5 * apart + 3 * shear);
    check(expected > 0 && std::fabs(body.von_mises(0) - expected) < 1e-12 * expected, "von Mises");
    check(e[3] * s[3] > 0, "strain");
    refused([&] { body.stress(body.stress_points()); }, "");
    refused([&] { body.stress_point(body.stress_points()); }, "");
    refused([&] { body.throw_({}); }, "supports");
    check(body.read("von_mises")[0] == body.von_mises(0), "a quantity");
}

static void reactions(Body body) {
    const auto exerted = body.reaction(body.find(Named::support, "left"));
    check(exerted[2] != 0, "a reaction");
    refused([&] { body.reaction(99); }, "");
}

static void flight(Body body) {
    body.clear();
    body.rest();
    body.throw_({0, 0, 3}, {5, 1, 0});
    const RigidBody mass = body.rigid_body();
    const double step = body.needs().time_step;
    for (int k = 0; k < 100; k++) {
        body.pull({0, 0, -9.81 * mass.mass});
        const double ahead = body.ahead().position[2];
        check(body.step() && body.motion().position[2] == ahead, "ahead");
    }
    const double time = 100 * step, height = mass.centre[2] + 3 * time - 0.5 * 9.81 * time * time;
    Motion motion = body.motion();
    check(std::fabs(motion.position[2] - height) < 1e-12, "the height of a thrown body");

    // Where a place goes in a short step is its velocity.
    const Place place = body.at_node(0);
    const Vector before = body.in_space(place), speed = body.in_space(place, Field::velocity);
    body.step();
    const Vector after = body.in_space(place);
    for (int k = 0; k < 3; k++) {
        const double rate = (after[k] - before[k]) / step;
        check(std::fabs(rate - speed[k]) < 0.05 * (1 + std::fabs(speed[k])), "the velocity of a place");
    }
    body.push(place, {1, 0, 0});
    body.push_pattern(0, 1);
    body.step();
    check(body.motion().momentum[0] != motion.momentum[0], "a push");
    motion.attitude[0] = std::nan("");
    refused([&] { body.set_motion(motion); }, "finite");
}

static void files(const char *path) {
    const File file = File::read(path);
    file.verify();
    check(file.size() > 0 && file.data()[0] == 0x89 && file.measure().memory > 0, "a file");
    refused([] { File::read("nowhere.vdm"); }, "nowhere.vdm: cannot be read");
    refused([] { File(std::vector<std::uint8_t>(8)).measure(); }, "");
    try {
        File(std::vector<std::uint8_t>()).verify();
        check(false, "no bytes");
    } catch (const Error &error) {
        check(error.status() == VDM_FILE || error.status() == VDM_ARGUMENT, "a status");
    }
    Memory memory(100);
    check(memory.size() >= 100 && reinterpret_cast<std::uintptr_t>(memory.data()) % 16 == 0, "aligned memory");
}

// Places, loads that change within a step, kept loads, and states.
static void loads(const File &file) {
    Options options = default_options();
    options.keep_loads = 1;
    Body body(file, options);
    const Place place = body.at_node(body.needs().load_nodes - 1);
    const Vector force{1, -2, -20};
    const auto instants = body.instants();
    check(body.handle() != nullptr && instants[1] > 0, "instants");
    check(body.locate({place.position[0], place.position[1], place.position[2]}).distance < 1e-9, "the place of a node");
    refused([&] { body.locate({1e3, 0, 0}); }, "away from the loadable surface");
    check(!body.step(3), "at rest");
    body.push(place, force);
    body.keep_loads();
    body.step(5);
    const Vector moved = body.point(place);
    check(moved[2] < 0 && body.energy() > 0 && body.node(place.nodes[0])[2] < 0, "a push");
    check(body.probe(0) < 0 && body.probe(0, Field::velocity) != 0, "a probe");
    body.rest();
    body.clear();
    body.push_ramp(place, force, force);
    body.step(5);
    check(std::fabs(body.point(place)[2] - moved[2]) < 1e-6 * std::fabs(moved[2]), "a ramp");
    body.clear();
    body.rest();
    body.push_staged(place, force, {1, 1, 1, 1});
    body.step(5);
    check(std::fabs(body.point(place)[2] - moved[2]) < 1e-6 * std::fabs(moved[2]), "a staged push");
    body.rest();
    body.recall_loads();
    body.step(5);
    check(body.point(place) == moved, "kept loads");

    const std::vector<std::uint8_t> saved = body.save();
    body.step(5);
    check(!body.restore(saved) && body.point(place) == moved, "a state");
    body.set(std::vector<double>(body.needs().modes, 1e-3), std::vector<double>(body.needs().modes));
    check(body.energy() > 0, "a state that is set");
    refused([&] { body.set({1}, {}); }, "not as many rates");
    check(body.cost().step_operations > 0, "the cost of a step");
    const std::vector<double> w = body.compliance({place}), gone = body.free_motion({place});
    check(w.size() == 9 && w[8] > 0 && gone.size() == 3, "compliance");
    if (body.needs().patterns > 0) {
        body.clear();
        body.rest();
        body.push_pattern_ramp(0, 0, 1);
        body.push_pattern_staged(0, {0, 1, 1, 1});
        body.step();
        check(body.energy() > 0, "a pattern that changes");
    }
}

static void fields(const File &file, bool is_double) {
    Options options = default_options();
    options.static_field = 1;
    options.precision = is_double ? VDM_DOUBLE : VDM_SINGLE;
    Body body(file, options);
    const std::size_t surface = 3 * std::size_t{body.needs().surface_nodes}, all = 3 * std::size_t{body.needs().nodes};
    check(body.positions().size() == surface && body.triangles().size() == 3 * std::size_t{body.needs().triangles}, "the shape");
    const auto embedded = body.embedded_triangles();
    if (!embedded.empty()) check(body.embedded(body.positions()).size() % 3 == 0, "the embedded surface");
    // A loadable node that no support holds.
    const std::uint32_t node = body.needs().load_nodes - 1;
    const std::size_t z = 3 * std::size_t{node} + 2;
    body.push(body.at_node(node), {1, -2, -20});
    body.step(5);
    body.solve_statics();
    const auto read = [&](auto number) {
        using Number = decltype(number);
        std::vector<Number> of_surface(surface), of_all(all);
        body.surface(Field::velocity, of_surface.data(), surface);
        body.whole(Field::velocity, of_all.data(), all);
        check(of_surface[z] != 0 && of_surface[z] == of_all[z], "a field");
        body.surface_with_statics(Field::displacement, of_surface.data(), surface);
        body.whole_with_statics(Field::displacement, of_all.data(), all);
        check(of_surface[z] != 0 && of_surface[z] == of_all[z], "a field with statics");
    };
    is_double ? read(double{}) : read(float{});
}

static void parameters(Body body) {
    const std::string name = body.name(Named::parameter, 0);
    const std::uint32_t first = body.find(Named::parameter, name);
    const VdmParameter found = body.parameter(first);
    body.set_parameter(first, found.upper);
    check(body.parameter(first).value == found.upper, "a live parameter");
    body.set_parameters({first}, {found.lower});
    check(body.parameter(first).value == found.lower, "live parameters");
    refused([&] { body.set_parameters({first}, {}); }, "not as many values");
    refused([&] { body.set_parameter(first, 2 * found.upper); }, "range");
    refused([&] { body.find(Named::probe, "nowhere"); }, "nowhere");
}

static void regions(Body body) {
    check(body.carried().work == 0, "nothing is set yet");
    body.set_parameter(0, body.parameter(0).upper);
    const VdmCarried carried = body.carried();
    const double lost = std::fabs(carried.lost_kinetic) + std::fabs(carried.lost_elastic);
    check(carried.work > 0 && lost < 1e-6 * carried.work, "all modes hold the motion of a stiffer body");
    parameters(std::move(body));
}

static void base(Body body) {
    body.clear();
    body.rest();
    body.push_base({1, 2, 3}, {}, {});
    check(body.step() && body.energy() > 0, "a base that moves");
}

static void spun(const File &file) {
    Options options = default_options();
    options.flight = 0;
    Body body(file, options);
    body.push_spin({}, {1, 0, 0});
    check(body.step() && body.energy() > 0, "a body that its host spins");
}

// Memory of a body and of its instances stays where it is when they are moved.
static void moved(const File &file) {
    Body first(file), other(file);
    const Place place = first.at_node(first.needs().load_nodes - 1);
    other.push(place, {0, 0, -20});
    other.step(20);
    const double energy = other.energy();
    first.push(place, {0, 0, -20});
    Batch batch(first, 20);
    batch.load(3);
    Body second(std::move(first));
    Batch moved(std::move(batch));
    check(batch.size() == 0 && moved.size() == 20, "moved instances");
    refused([&] { first.step(); }, "null");
    refused([&] { batch.clear(); }, "null");
    second.step(10);
    other = std::move(second);
    check(other.step(10) && std::fabs(other.energy() / energy - 1) < 1e-6, "a moved body");
    check(moved.step(20).moving == 1, "instances of a moved body");
    moved.get_under(3);
    moved.get(3);
    moved.set(4);
    moved.carry();
    moved.clear();
    Batch third(other, 1);
    third = std::move(moved);
    check(third.size() == 20 && third.step().at_rest >= 18, "instances that were moved twice");
    std::vector<Body> bodies;
    for (int k = 0; k < 5; k++) bodies.push_back(Body(file));
    for (Body &body : bodies) body.push(place, {0, 0, -20});
    for (Body &body : bodies) check(body.step(20) && body.energy() == energy, "bodies of a vector");
}

static void world(const File &cube, const File &base, const File &link) {
    Options options = default_options();
    options.time_step = 1e-3;
    options.contacts = 128;
    Body falls(cube, options), stands(base, options), swings(link, options);
    Motion motion = falls.motion();
    motion.position[0] += 0.04;
    motion.position[1] += 0.04;
    motion.position[2] += 0.085;
    falls.set_motion(motion);
    const std::vector<Vector> nodes = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
    const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 1, 2}};
    Pose below;
    below.position[2] = -1;
    Member die = World::rigid(nodes, triangles, below);
    die.mass = falls.rigid_body();
    const std::vector<Member> members = {World::body(falls), World::body(stands), World::rigid(nodes, triangles, below),
                                         World::body(swings), World::rigid({}, {}), die};
    Touching pair{};
    pair.second = 1;
    pair.friction = 0.5;
    pair.restitution = 0.5;
    pair.nodes = VDM_NODES_FIRST;
    Joint hinge{};
    hinge.kind = VDM_HINGE;
    hinge.first = 3;
    hinge.second = 4;
    hinge.anchors[0].kind = VDM_AT_PORT;
    hinge.anchors[0].port = swings.find(Named::port, "start");
    hinge.anchors[1].kind = VDM_AT_POINT;
    hinge.anchors[1].point[1] = hinge.anchors[1].point[2] = 0.01;
    WorldOptions falling = default_world_options();
    falling.gravity[2] = -9.81;
    falling.contacts = 128;
    World first({members}, {pair}, {hinge}, falling);
    World world(std::move(first));
    refused([&] { first.step(); }, "null");
    check(world.step(300).pressed > 0 && world.energy() > 0, "a world");
    double carried = 0;
    for (const Touch &touch : world.touches()) carried += touch.force[2];
    check(std::fabs(carried / (falls.rigid_body().mass * 9.81) - 1) < 0.05, "the base carries the cube");
    const Place place = falls.locate({0.08, 0.08, 0.08});
    check(std::fabs(world.in_space(0, place)[2] - 0.16) < 2e-3 && std::fabs(world.pose(0).position[2] - 0.08) < 2e-3, "in space");
    check(std::fabs(world.in_space(0, place, Field::velocity)[2]) < 0.1, "velocity in space");
    check(!world.joint(0).broken && std::fabs(world.joint(0).force[2]) > 1e-3, "a joint");
    world.break_joint(0);
    check(world.joint(0).broken != 0, "a broken joint");
    refused([&] { world.break_joint(1); }, "no such");
    below.position[2] = -0.5;
    world.lead(2, below);
    motion = world.motion(5);
    world.push(5, {motion.position[0], motion.position[1], motion.position[2]}, {0, 1, 0});
    world.step();
    check(std::fabs(world.motion(5).momentum[1] - 1e-3) < 1e-12 && world.pose(2).position[2] == -0.5, "rigid members");
    world.set_motion(5, motion);
    world.forget();
    world.step(5);
    const std::vector<double> saved = world.save();
    const std::vector<std::uint8_t> states[] = {falls.save(), stands.save(), swings.save()};
    world.step(20);
    const double energy = world.energy();
    world.restore(saved);
    falls.restore(states[0]);
    stands.restore(states[1]);
    swings.restore(states[2]);
    world.step(20);
    check(world.energy() == energy, "a restored world");
    world = World({World::body(stands)}, {});
    world.step();
    refused([&] { World({World::body(stands), World::body(stands)}, {}); }, "once");
}

int main(int count, char **paths) {
    check(count == 11, "ten files");
    stress(pushed(paths[1]));
    reactions(pushed(paths[2]));
    flight(pushed(paths[3]));
    spun(File::read(paths[3]));
    files(paths[4]);
    parameters(pushed(paths[4]));
    refused([&] { pushed(paths[4]).carried(); }, "live regions");
    regions(pushed(paths[10]));
    const File whole = File::read(paths[5]);
    loads(whole);
    fields(whole, false);
    fields(whole, true);
    moved(whole);
    base(pushed(paths[6]));
    world(File::read(paths[7]), File::read(paths[8]), File::read(paths[9]));
    return 0;
}
