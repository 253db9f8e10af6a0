// vademecum for C++17: the C interface behind types that own their memory. Refusals are exceptions of type
// vademecum::Error, which say what the C call says; nothing is thrown or allocated while a body is stepped, apart from that.
// A program without exceptions uses vademecum.h.
#ifndef VADEMECUM_HPP
#define VADEMECUM_HPP

#if !defined(__cpp_exceptions) && !defined(_CPPUNWIND)
#error "vademecum.hpp needs exceptions; compile with them, or use vademecum.h"
#endif

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "vademecum.h"

namespace vademecum {

// What was refused, and the status of the C call.
class Error : public std::runtime_error {
public:
    Error(VdmStatus status, const std::string &what) : std::runtime_error(what), status_(status) {}
    VdmStatus status() const noexcept { return status_; }

private:
    VdmStatus status_;
};

using Vector = std::array<double, 3>;
// A stress or a strain: xx, yy, zz, xy, yz, zx.
using Tensor = std::array<double, 6>;
using Place = VdmPlace;
using Options = VdmOptions;
using Needs = VdmNeeds;
using RigidBody = VdmRigidBody;
using Motion = VdmMotion;

enum class Field : std::int32_t { displacement = VDM_DISPLACEMENT, velocity = VDM_VELOCITY };
enum class Named : std::int32_t {
    probe = VDM_PROBES,
    pattern = VDM_PATTERNS,
    parameter = VDM_PARAMETERS,
    support = VDM_SUPPORTS,
    port = VDM_PORTS
};

// The file as it was built; change what is to differ.
inline Options default_options() {
    Options options;
    vdm_default_options(&options);
    return options;
}

// The bytes of a file. Bodies keep it alive.
class File {
public:
    explicit File(std::vector<std::uint8_t> bytes)
        : bytes_(std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes))) {
        if (vdm_abi() != VDM_ABI)
            throw Error(VDM_ARGUMENT, "header and library of vademecum are of two versions: compile against the header "
                                      "that came with the library");
    }

    static File read(const std::string &path) {
        struct Close {
            void operator()(std::FILE *file) const { static_cast<void>(std::fclose(file)); }
        };
        std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rb"));
        if (!file) throw Error(VDM_FILE, path + ": cannot be read; check the path and its permissions");
        std::vector<std::uint8_t> bytes;
        std::array<std::uint8_t, 65536> part;
        while (const std::size_t count = std::fread(part.data(), 1, part.size(), file.get()))
            bytes.insert(bytes.end(), part.begin(), part.begin() + static_cast<std::ptrdiff_t>(count));
        if (std::ferror(file.get()) || std::fclose(file.release()) != 0)
            throw Error(VDM_FILE, path + ": reading stopped with an error");
        return File(std::move(bytes));
    }

    // Compares every section with its checksum, which opening does not.
    void verify() const {
        std::array<char, 240> text{};
        check(vdm_verify(data(), size(), text.data(), text.size()), text);
    }

    Needs measure(const Options &options = default_options()) const {
        std::array<char, 240> text{};
        Needs needs;
        check(vdm_measure(data(), size(), &options, &needs, text.data(), text.size()), text);
        return needs;
    }

    const std::uint8_t *data() const noexcept { return bytes_->data(); }
    std::size_t size() const noexcept { return bytes_->size(); }

    static void check(VdmStatus status, const std::array<char, 240> &text) {
        if (status < 0) throw Error(status, text.data());
    }

private:
    std::shared_ptr<const std::vector<std::uint8_t>> bytes_;
};

// Memory aligned to 16, as the C interface wants it.
class Memory {
public:
    explicit Memory(std::size_t bytes) : units_(bytes / sizeof(Unit) + 1) {}
    std::uint8_t *data() noexcept { return units_.data()->bytes; }
    std::size_t size() const noexcept { return units_.size() * sizeof(Unit); }

private:
    struct alignas(16) Unit {
        std::uint8_t bytes[16];
    };
    std::vector<Unit> units_;
};

class Batch;

// A body with one state and its loads. It belongs to one thread at a time; it can be moved, not copied.
class Body {
public:
    explicit Body(File file, const Options &options = default_options())
        : file_(std::move(file)), options_(options), needs_(file_.measure(options)), memory_(needs_.memory) {
        std::array<char, 240> text{};
        File::check(vdm_bind(file_.data(), file_.size(), &options_, memory_.data(), memory_.size(), &handle_,
                             text.data(), text.size()),
                    text);
    }
    Body(const Body &) = delete;
    Body &operator=(const Body &) = delete;
    // The lent memory is on the heap and does not move.
    Body(Body &&other) noexcept
        : file_(std::move(other.file_)), options_(other.options_), needs_(other.needs_), memory_(std::move(other.memory_)),
          handle_(std::exchange(other.handle_, nullptr)) {}
    Body &operator=(Body &&other) noexcept {
        std::swap(file_, other.file_);
        std::swap(options_, other.options_);
        std::swap(needs_, other.needs_);
        std::swap(memory_, other.memory_);
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Body() = default;

    const Needs &needs() const noexcept { return needs_; }
    VdmBody *handle() noexcept { return handle_; }

    // Steps; true while the body moves or is loaded, false at rest.
    bool step(std::uint64_t steps = 1) { return check(vdm_step(handle_, steps)) != VDM_AT_REST; }
    void rest() { check(vdm_rest(handle_)); }

    Place locate(const Vector &point) {
        Place place;
        check(vdm_locate(handle_, point.data(), &place));
        return place;
    }
    Place at_node(std::uint32_t node) {
        Place place;
        check(vdm_at_node(handle_, node, &place));
        return place;
    }

    void clear() { check(vdm_clear(handle_)); }
    void push(const Place &place, const Vector &force) { check(vdm_push(handle_, &place, force.data())); }
    void push_pattern(std::uint32_t pattern, double amplitude) { check(vdm_push_pattern(handle_, pattern, amplitude)); }
    void push_ramp(const Place &place, const Vector &start, const Vector &end) {
        check(vdm_push_ramp(handle_, &place, start.data(), end.data()));
    }
    void push_pattern_ramp(std::uint32_t pattern, double start, double end) {
        check(vdm_push_pattern_ramp(handle_, pattern, start, end));
    }
    std::array<double, 4> instants() {
        std::array<double, 4> instants;
        check(vdm_instants(handle_, instants.data()));
        return instants;
    }
    void push_staged(const Place &place, const Vector &force, const std::array<double, 4> &amplitudes) {
        check(vdm_push_staged(handle_, &place, force.data(), amplitudes.data()));
    }
    void push_pattern_staged(std::uint32_t pattern, const std::array<double, 4> &amplitudes) {
        check(vdm_push_pattern_staged(handle_, pattern, amplitudes.data()));
    }
    void push_base(const Vector &acceleration, const Vector &angular_velocity, const Vector &angular_acceleration) {
        check(vdm_push_base(handle_, acceleration.data(), angular_velocity.data(), angular_acceleration.data()));
    }
    void keep_loads() { check(vdm_keep_loads(handle_)); }
    void recall_loads() { check(vdm_recall_loads(handle_)); }

    // The number of a probe, a pattern or a live parameter.
    std::uint32_t find(Named kind, const std::string &name) {
        const std::int32_t found = vdm_find(handle_, static_cast<std::int32_t>(kind), name.c_str());
        if (found < 0) throw Error(VDM_ARGUMENT, "the file has nothing of the name `" + name + "`");
        return static_cast<std::uint32_t>(found);
    }
    std::string name(Named kind, std::uint32_t index) {
        std::array<char, 1024> text{};
        check(vdm_name(handle_, static_cast<std::int32_t>(kind), index, text.data(), text.size()));
        return text.data();
    }
    VdmParameter parameter(std::uint32_t index) {
        VdmParameter found;
        check(vdm_parameter(handle_, index, &found));
        return found;
    }
    // Loads become stale: clear them and add them again.
    void set_parameter(std::uint32_t index, double value) { check(vdm_set_parameters(handle_, &index, &value, 1)); }
    void set_parameters(const std::vector<std::uint32_t> &ids, const std::vector<double> &values) {
        if (ids.size() != values.size()) throw Error(VDM_ARGUMENT, "not as many values as parameters");
        check(vdm_set_parameters(handle_, ids.data(), values.data(), ids.size()));
    }
    VdmCarried carried() {
        VdmCarried found;
        check(vdm_carried(handle_, &found));
        return found;
    }

    // Any quantity of the table, by its name.
    std::vector<double> read(const std::string &quantity, std::size_t index = 0, Field field = Field::displacement) {
        const std::int32_t found = vdm_find_quantity(quantity.c_str());
        if (found < 0) throw Error(VDM_ARGUMENT, "there is no quantity of the name `" + quantity + "`");
        const std::uint32_t which = static_cast<std::uint32_t>(found);
        std::vector<double> out(vdm_length(handle_, which));
        check(vdm_read(handle_, which, index, number(field), out.data(), out.size()));
        return out;
    }
    double probe(std::uint32_t index, Field field = Field::displacement) {
        double value = 0;
        check(vdm_probe(handle_, index, number(field), &value));
        return value;
    }
    Vector point(const Place &place, Field field = Field::displacement) {
        Vector value;
        check(vdm_point(handle_, &place, number(field), value.data()));
        return value;
    }
    Vector node(std::uint32_t node, Field field = Field::displacement) {
        Vector value;
        check(vdm_node(handle_, node, number(field), value.data()));
        return value;
    }
    // Force and moment that a support exerts on the body.
    std::array<double, 6> reaction(std::uint32_t support) {
        std::array<double, 6> value;
        check(vdm_reaction(handle_, support, value.data()));
        return value;
    }
    // Stress and strain at the points that the file knows them of, counted from 0.
    std::uint32_t stress_points() { return vdm_stress_points(handle_); }
    // Node of the file and region of the mesh.
    std::array<std::uint32_t, 2> stress_point(std::uint32_t point) {
        std::array<std::uint32_t, 2> where{};
        check(vdm_stress_point(handle_, point, where.data()));
        return where;
    }
    // In Pa.
    Tensor stress(std::uint32_t point) {
        Tensor value;
        check(vdm_stress(handle_, point, value.data()));
        return value;
    }
    Tensor strain(std::uint32_t point) {
        Tensor value;
        check(vdm_strain(handle_, point, value.data()));
        return value;
    }
    double von_mises(std::uint32_t point) {
        double value = 0;
        check(vdm_von_mises(handle_, point, &value));
        return value;
    }
    double energy() {
        double value = 0;
        check(vdm_energy(handle_, &value));
        return value;
    }
    // Three numbers a node, into a buffer of the precision of the body: 3 surface_nodes, or 3 nodes.
    void surface(Field field, float *out, std::size_t count) { check(vdm_surface_f32(handle_, number(field), out, count)); }
    void surface(Field field, double *out, std::size_t count) { check(vdm_surface_f64(handle_, number(field), out, count)); }
    void whole(Field field, float *out, std::size_t count) { check(vdm_whole_f32(handle_, number(field), out, count)); }
    void whole(Field field, double *out, std::size_t count) { check(vdm_whole_f64(handle_, number(field), out, count)); }
    std::vector<double> positions() {
        std::vector<double> out(3 * std::size_t{needs_.surface_nodes});
        check(vdm_positions(handle_, out.data(), out.size()));
        return out;
    }
    std::vector<std::uint32_t> triangles() {
        std::vector<std::uint32_t> out(3 * std::size_t{needs_.triangles});
        check(vdm_triangles(handle_, out.data(), out.size()));
        return out;
    }

    // The embedded surface, which is drawn in place of that of the mesh: its triangles, none where a file has
    // none, and positions or displacements at its vertices from those at the nodes of the surface.
    std::vector<std::uint32_t> embedded_triangles() {
        std::uint32_t vertices = 0, triangles = 0;
        check(vdm_embedded_sizes(handle_, &vertices, &triangles));
        std::vector<std::uint32_t> out(3 * std::size_t{triangles});
        if (triangles != 0) check(vdm_embedded_triangles(handle_, out.data(), out.size()));
        return out;
    }
    std::vector<double> embedded(const std::vector<double> &at_nodes) {
        std::uint32_t vertices = 0, triangles = 0;
        check(vdm_embedded_sizes(handle_, &vertices, &triangles));
        std::vector<double> out(3 * std::size_t{vertices});
        check(vdm_embedded_interpolate(handle_, at_nodes.data(), at_nodes.size(), out.data(), out.size()));
        return out;
    }

    // The static answer of the whole body, of a body bound with Options::static_field, and fields that show it.
    void solve_statics() { check(vdm_solve_statics(handle_)); }
    void surface_with_statics(Field field, float *out, std::size_t count) {
        check(vdm_surface_with_statics_f32(handle_, number(field), out, count));
    }
    void surface_with_statics(Field field, double *out, std::size_t count) {
        check(vdm_surface_with_statics_f64(handle_, number(field), out, count));
    }
    void whole_with_statics(Field field, float *out, std::size_t count) {
        check(vdm_whole_with_statics_f32(handle_, number(field), out, count));
    }
    void whole_with_statics(Field field, double *out, std::size_t count) {
        check(vdm_whole_with_statics_f64(handle_, number(field), out, count));
    }

    std::vector<std::uint8_t> save() {
        std::vector<std::uint8_t> bytes(vdm_saved_length(handle_));
        std::size_t written = 0;
        check(vdm_save(handle_, bytes.data(), bytes.size(), &written));
        bytes.resize(written);
        return bytes;
    }
    // True if the state was carried over to other parameters or another precision.
    bool restore(const std::vector<std::uint8_t> &bytes) {
        return check(vdm_restore(handle_, bytes.data(), bytes.size())) == VDM_CARRIED;
    }
    void set(const std::vector<double> &zeta, const std::vector<double> &zeta_dot) {
        if (zeta.size() != zeta_dot.size()) throw Error(VDM_ARGUMENT, "not as many rates as coordinates");
        check(vdm_set(handle_, zeta.data(), zeta_dot.data(), zeta.size()));
    }

    // How places yield in the coming step, row by row, and where they go without further forces.
    std::vector<double> compliance(const std::vector<Place> &places) {
        std::vector<double> w(9 * places.size() * places.size());
        check(vdm_compliance(handle_, places.data(), places.size(), w.data()));
        return w;
    }
    std::vector<double> free_motion(const std::vector<Place> &places) {
        std::vector<double> out(3 * places.size());
        check(vdm_free_motion(handle_, places.data(), places.size(), out.data()));
        return out;
    }
    VdmCost cost() { return get<VdmCost>(vdm_cost); }

    // The motion in space of a body without supports, which `step` moves, too. Its forces and positions are those of
    // space; forces act in one step.
    RigidBody rigid_body() { return get<RigidBody>(vdm_rigid_body); }
    void throw_(const Vector &velocity, const Vector &spin = {}) {
        check(vdm_throw(handle_, velocity.data(), spin.data()));
    }
    Motion motion() { return get<Motion>(vdm_motion); }
    Motion ahead() { return get<Motion>(vdm_ahead); }
    void set_motion(const Motion &motion) { check(vdm_set_motion(handle_, &motion)); }
    // At the centre: gravity is the mass times its acceleration.
    void pull(const Vector &force) { check(vdm_pull(handle_, force.data())); }
    Vector in_space(const Place &place, Field field = Field::displacement) {
        Vector value;
        check(vdm_in_space(handle_, &place, number(field), value.data()));
        return value;
    }
    // For a host that moves the body itself (Options::flight = 0): its angular velocity before and after the step.
    void push_spin(const Vector &before, const Vector &after) {
        check(vdm_push_spin(handle_, before.data(), after.data()));
    }

private:
    friend class Batch;

    static std::int32_t number(Field field) { return static_cast<std::int32_t>(field); }

    template <typename T> T get(VdmStatus (*call)(VdmBody *, T *)) {
        T value;
        check(call(handle_, &value));
        return value;
    }

    VdmStatus check(VdmStatus status) { return check(handle_, status); }
    static VdmStatus check(const VdmBody *body, VdmStatus status) {
        if (status < 0) {
            const char *said = vdm_message(body);
            throw Error(status, *said ? said : vdm_status_text(status));
        }
        return status;
    }

    File file_;
    Options options_;
    Needs needs_;
    Memory memory_;
    VdmBody *handle_ = nullptr;
};

// Many instances of a body, which must live as long as they do; both can be moved, not copied.
class Batch {
public:
    Batch(Body &body, std::size_t instances)
        : body_(body.handle_), count_(instances), memory_(vdm_batch_bytes(body_, instances)) {
        check(vdm_batch_bind(body_, instances, memory_.data(), memory_.size(), &handle_));
    }
    Batch(const Batch &) = delete;
    Batch &operator=(const Batch &) = delete;
    Batch(Batch &&other) noexcept
        : body_(std::exchange(other.body_, nullptr)), count_(std::exchange(other.count_, 0)), memory_(std::move(other.memory_)),
          handle_(std::exchange(other.handle_, nullptr)) {}
    Batch &operator=(Batch &&other) noexcept {
        std::swap(body_, other.body_);
        std::swap(count_, other.count_);
        std::swap(memory_, other.memory_);
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Batch() = default;

    std::size_t size() const noexcept { return count_; }
    // Loads an instance with the loads of the body, in place of what it had.
    void load(std::size_t instance) { check(vdm_batch_load(handle_, body_, instance)); }
    void clear() { check(vdm_batch_clear(handle_)); }
    // Gives the body the state of an instance, whose last step was one under the loads that the body has now: so reactions
    // can be read.
    void get_under(std::size_t instance) { check(vdm_batch_get_under(handle_, body_, instance)); }
    // Gives an instance the state of the body, or the body the state of an instance.
    void set(std::size_t instance) { check(vdm_batch_set(handle_, body_, instance)); }
    void get(std::size_t instance) { check(vdm_batch_get(handle_, body_, instance)); }
    VdmBatchStatus step(std::uint64_t steps = 1) {
        VdmBatchStatus found{};
        check(vdm_batch_step(handle_, body_, steps, &found));
        return found;
    }
    void carry() { check(vdm_batch_carry(handle_, body_)); }

private:
    VdmStatus check(VdmStatus status) const { return Body::check(body_, status); }

    // The handle of the body, which does not move with it.
    VdmBody *body_;
    std::size_t count_;
    Memory memory_;
    VdmBatch *handle_ = nullptr;
};

using Member = VdmMember;
using Touching = VdmTouching;
using Joint = VdmJoint;
using Touch = VdmTouch;
using JointState = VdmJointState;
using WorldOptions = VdmWorldOptions;
using WorldReport = VdmWorldReport;

// Place of the origin of the coordinates of a member, and its rotation, a quaternion, the real part first.
struct Pose {
    Vector position{};
    std::array<double, 4> attitude{1, 0, 0, 0};
};

// A world without gravity, with room for 256 contacts; change what is to differ.
inline WorldOptions default_world_options() {
    WorldOptions options;
    vdm_default_world_options(&options);
    return options;
}

// Bodies that touch with friction, and joints that turn far. The bodies, and the nodes and triangles of rigid members, must live
// as long as it does; all can be moved, not copied.
class World {
public:
    World(const std::vector<Member> &members, const std::vector<Touching> &pairs, const std::vector<Joint> &joints = {},
          const WorldOptions &options = default_world_options())
        : memory_(measure(members, pairs, joints, options)) {
        std::array<char, 240> text{};
        File::check(vdm_world_bind(members.data(), members.size(), pairs.data(), pairs.size(), joints.data(), joints.size(),
                                   &options, memory_.data(), memory_.size(), &handle_, text.data(), text.size()),
                    text);
    }
    World(const World &) = delete;
    World &operator=(const World &) = delete;
    World(World &&other) noexcept : memory_(std::move(other.memory_)), handle_(std::exchange(other.handle_, nullptr)) {}
    World &operator=(World &&other) noexcept {
        std::swap(memory_, other.memory_);
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~World() = default;

    // A body as a member; one with supports stands at the pose.
    static Member body(Body &body, const Pose &pose = {}) {
        Member member{};
        member.body = body.handle();
        for (std::size_t k = 0; k < 3; k++) member.motion.position[k] = pose.position[k];
        for (std::size_t k = 0; k < 4; k++) member.motion.attitude[k] = pose.attitude[k];
        return member;
    }
    // A rigid body that the host leads, within a surface of nodes and triangles.
    static Member rigid(const std::vector<Vector> &nodes, const std::vector<std::array<std::uint32_t, 3>> &triangles,
                        const Pose &pose = {}) {
        Member member{};
        member.nodes = nodes.empty() ? nullptr : nodes.data()->data();
        member.n_nodes = nodes.size();
        member.triangles = triangles.empty() ? nullptr : triangles.data()->data();
        member.n_triangles = triangles.size();
        for (std::size_t k = 0; k < 3; k++) member.motion.position[k] = pose.position[k];
        for (std::size_t k = 0; k < 4; k++) member.motion.attitude[k] = pose.attitude[k];
        return member;
    }

    WorldReport step(std::uint64_t steps = 1) {
        WorldReport report{};
        check(vdm_world_step(handle_, steps, &report));
        return report;
    }
    double energy() {
        double energy = 0;
        check(vdm_world_energy(handle_, &energy));
        return energy;
    }
    Pose pose(std::uint32_t member) {
        Pose pose;
        check(vdm_world_pose(handle_, member, pose.position.data(), pose.attitude.data()));
        return pose;
    }
    // Puts a body with supports elsewhere, or leads a rigid member without a mass there to the end of the coming step.
    void lead(std::uint32_t member, const Pose &pose) {
        check(vdm_world_lead(handle_, member, pose.position.data(), pose.attitude.data()));
    }
    // Of a rigid member; a body has a motion of its own.
    Motion motion(std::uint32_t member) {
        Motion motion;
        check(vdm_world_motion(handle_, member, &motion));
        return motion;
    }
    void set_motion(std::uint32_t member, const Motion &motion) { check(vdm_world_set_motion(handle_, member, &motion)); }
    // Pushes a rigid member at a point of space in the coming step; a body is pushed itself.
    void push(std::uint32_t member, const Vector &point, const Vector &force) {
        check(vdm_world_push(handle_, member, point.data(), force.data()));
    }
    Vector in_space(std::uint32_t member, const Place &place, Field field = Field::displacement) {
        Vector value;
        check(vdm_world_in_space(handle_, member, &place, static_cast<std::int32_t>(field), value.data()));
        return value;
    }
    // Contacts of the last step.
    std::vector<Touch> touches() {
        std::size_t count = 0;
        check(vdm_world_touches(handle_, nullptr, 0, &count));
        std::vector<Touch> touches(count);
        check(vdm_world_touches(handle_, touches.data(), touches.size(), &count));
        return touches;
    }
    JointState joint(std::uint32_t joint) {
        JointState state;
        check(vdm_world_joint(handle_, joint, &state));
        return state;
    }
    void break_joint(std::uint32_t joint) { check(vdm_world_break(handle_, joint)); }
    // Forgets the contacts of the last step: after a member was put elsewhere.
    void forget() { check(vdm_world_forget(handle_)); }
    // Contacts, joints, placements of bodies with supports and motions of rigid members; the bodies are saved beside it.
    std::vector<double> save() {
        std::vector<double> saved(vdm_world_saved_length(handle_));
        check(vdm_world_save(handle_, saved.data(), saved.size()));
        return saved;
    }
    void restore(const std::vector<double> &saved) { check(vdm_world_restore(handle_, saved.data(), saved.size())); }

private:
    static std::size_t measure(const std::vector<Member> &members, const std::vector<Touching> &pairs,
                               const std::vector<Joint> &joints, const WorldOptions &options) {
        std::array<char, 240> text{};
        std::size_t bytes = 0;
        File::check(vdm_world_measure(members.data(), members.size(), pairs.data(), pairs.size(), joints.data(), joints.size(),
                                      &options, &bytes, text.data(), text.size()),
                    text);
        return bytes;
    }
    VdmStatus check(VdmStatus status) const {
        if (status < 0) {
            const char *said = vdm_world_message(handle_);
            throw Error(status, *said ? said : vdm_status_text(status));
        }
        return status;
    }

    Memory memory_;
    VdmWorld *handle_ = nullptr;
};

}  // namespace vademecum

#endif
