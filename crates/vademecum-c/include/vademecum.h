/*
 * vademecum: steps an elastic body in real time from a vademecum file.
 *
 * Nothing here allocates, locks, or keeps what is not lent to it. A body and the memory it lives in belong to one
 * thread at a time; bodies of one file may live in several threads.
 *
 * VDM_ABI 4 holds: later versions add calls and change none.
 */

#ifndef VADEMECUM_H
#define VADEMECUM_H

/* Made from crates/vademecum-c/src by its test `header`; do not edit. */

#include <stddef.h>
#include <stdint.h>

/*
 Version of this interface: callers compare it with the header they were compiled with. `VDM_ABI` 4 holds:
 later versions add calls and change none.
 */
#define VDM_ABI 4

/*
 Largest number of nodes of a place.
 */
#define VDM_MAX_PLACE_NODES 16

/*
 `VdmPlace.frame` of a place that is a list of nodes.
 */
#define VDM_NO_FRAME UINT32_MAX

/*
 Result of a call.
 */
typedef enum VdmStatus {
  /*
   Done; the body moves or is loaded.
   */
  VDM_OK = 0,
  /*
   Done; the body is at rest and further steps cost nothing.
   */
  VDM_AT_REST = 1,
  /*
   Done; the state that was restored was saved at other parameters or in another precision: displacement
   and velocity are what they were.
   */
  VDM_CARRIED = 2,
  /*
   A pointer is null or not aligned, or an index or a name is not the file's.
   */
  VDM_ARGUMENT = -1,
  /*
   Lent memory is too short or not aligned to 16 bytes.
   */
  VDM_MEMORY = -2,
  /*
   The bytes are no vademecum file that can be stepped.
   */
  VDM_FILE = -3,
  /*
   The file does not allow these options or this value.
   */
  VDM_BIND = -4,
  /*
   The load is refused: not finite, or at a place that is not loadable.
   */
  VDM_LOAD = -5,
  /*
   The step is refused; the state is unchanged.
   */
  VDM_STEP = -6,
  /*
   The file does not hold what is asked for.
   */
  VDM_OUTPUT = -7,
  /*
   The bytes are no saved state of this body.
   */
  VDM_STATE = -8,
  /*
   The world cannot have this member, pair or joint, or an option is not finite or negative.
   */
  VDM_WORLD = -9,
} VdmStatus;

/*
 In which numbers a body is stepped.
 */
typedef enum VdmPrecision {
  /*
   `float`: half the memory, and twice as fast.
   */
  VDM_SINGLE = 0,
  /*
   `double`.
   */
  VDM_DOUBLE = 1,
} VdmPrecision;

/*
 Displacement or velocity; what calls name `field`.
 */
typedef enum VdmField {
  /*
   m.
   */
  VDM_DISPLACEMENT = 0,
  /*
   m/s.
   */
  VDM_VELOCITY = 1,
} VdmField;

/*
 Kinds of named things in a file: the values of `kind`.
 */
typedef enum VdmNamed {
  /*
   Probes.
   */
  VDM_PROBES = 0,
  /*
   Load patterns.
   */
  VDM_PATTERNS = 1,
  /*
   Live parameters.
   */
  VDM_PARAMETERS = 2,
  /*
   Supports whose reactions the file gives.
   */
  VDM_SUPPORTS = 3,
  /*
   Ports, where joints of a world hold.
   */
  VDM_PORTS = 4,
} VdmNamed;

/*
 Structure of a step: the values of `structure`.
 */
typedef enum VdmStructure {
  /*
   The exact one if the file was built for it, else the cheapest that keeps the tolerance.
   */
  VDM_AUTO = 0,
  /*
   One 3 by 3 block for each mode.
   */
  VDM_DIAGONAL = 1,
  /*
   One dense map, for live regions.
   */
  VDM_BLOCK = 2,
  /*
   One 2 by 2 block for each mode, without error of time.
   */
  VDM_EXACT = 3,
  /*
   Large displacements.
   */
  VDM_STRAIN = 4,
} VdmStructure;

/*
 Kinds of joints: the values of `VdmJoint.kind`.
 */
typedef enum VdmJointKind {
  /*
   Two points stay together.
   */
  VDM_BALL = 0,
  /*
   Two points stay together, and the members turn about the third axis of the first anchor.
   */
  VDM_HINGE = 1,
  /*
   The second anchor stays on the third axis of the first, and the members do not turn against each
   other.
   */
  VDM_SLIDER = 2,
  /*
   Two points are no farther apart than a length.
   */
  VDM_CABLE = 3,
} VdmJointKind;

/*
 Kinds of anchors: the values of `VdmAnchor.kind`.
 */
typedef enum VdmAnchorKind {
  /*
   A place of the surface of a body, for a ball joint or a cable.
   */
  VDM_AT_PLACE = 0,
  /*
   A port of a body that is a frame.
   */
  VDM_AT_PORT = 1,
  /*
   A point of a rigid member, with axes.
   */
  VDM_AT_POINT = 2,
} VdmAnchorKind;

/*
 Members of a pair whose nodes are held off the surface of the other: the values of `VdmTouching.nodes`.
 */
typedef enum VdmNodes {
  /*
   Of both.
   */
  VDM_NODES_BOTH = 0,
  /*
   Of the first.
   */
  VDM_NODES_FIRST = 1,
  /*
   Of the second.
   */
  VDM_NODES_SECOND = 2,
} VdmNodes;

/*
 Many instances of a body, behind a handle.
 */
typedef struct VdmBatch VdmBatch;

/*
 A body, behind a handle.
 */
typedef struct VdmBody VdmBody;

/*
 A world, behind a handle.
 */
typedef struct VdmWorld VdmWorld;

/*
 Cost of a step of a body. Bytes are those of the file, apart from `step_bytes`.
 */
typedef struct VdmCost {
  /*
   Terms of the separated solution that binding adds up.
   */
  size_t terms;
  /*
   Read by binding and by every change of a parameter.
   */
  size_t bind_bytes;
  /*
   Multiply-adds of a step, which reads nothing of the file.
   */
  size_t step_operations;
  /*
   Lent memory that a step reads or writes.
   */
  size_t step_bytes;
  /*
   Rows that a contact reads when it is added.
   */
  size_t contact_rows;
  /*
   Read when a contact is added.
   */
  size_t contact_bytes;
  /*
   Read when a load pattern is added.
   */
  size_t pattern_bytes;
  /*
   Read by one probe.
   */
  size_t probe_bytes;
  /*
   Read by one node.
   */
  size_t node_bytes;
  /*
   Read by the surface.
   */
  size_t surface_bytes;
  /*
   Read by the whole body.
   */
  size_t body_bytes;
} VdmCost;

/*
 A live parameter.
 */
typedef struct VdmParameter {
  /*
   Smallest value.
   */
  double lower;
  /*
   Largest value.
   */
  double upper;
  /*
   The value that the file was built around.
   */
  double nominal;
  /*
   The value that the body has now.
   */
  double value;
  /*
   Not 0: its range is best walked in the logarithm.
   */
  uint32_t logarithmic;
} VdmParameter;

/*
 Energies of the last change of live parameters, in J.
 */
typedef struct VdmCarried {
  /*
   Kinetic energy that the stepped modes at the new values do not hold.
   */
  double lost_kinetic;
  /*
   Elastic energy that they do not hold.
   */
  double lost_elastic;
  /*
   Work of the change of stiffness on the displacement as it is.
   */
  double work;
} VdmCarried;

/*
 Result of a step of many instances.
 */
typedef struct VdmBatchStatus {
  /*
   Instances that moved or are loaded.
   */
  size_t moving;
  /*
   Instances at rest.
   */
  size_t at_rest;
  /*
   Instances whose new state would not be finite; they keep the old one.
   */
  size_t refused;
} VdmBatchStatus;

/*
 Options of binding a body. Fill it with `vdm_default_options` first.
 */
typedef struct VdmOptions {
  /*
   In which numbers the body is stepped: a `VdmPrecision`.
   */
  int32_t precision;
  /*
   Structure of a step: a `VdmStructure`.
   */
  int32_t structure;
  /*
   For so many contacts with nodes of their own there is room in the residual flexibility.
   */
  uint32_t contacts;
  /*
   With `beta`: filtered forces of so many nodes are kept for the residual flexibility; 0: of all
   loadable nodes. A node counts until its filtered force is below 1e-12 of the largest.
   */
  uint32_t filtered_nodes;
  /*
   0: outputs show the modes only.
   */
  uint32_t residual;
  /*
   `vdm_compliance` and `vdm_free_motion` take so many places at most.
   */
  uint32_t places;
  /*
   Not 0: there is room for `vdm_keep_loads`.
   */
  uint32_t keep_loads;
  /*
   Not 0: there is room for `vdm_solve_statics`, where the file has the factor of its stiffness.
   */
  uint32_t static_field;
  /*
   Not 0: a body without supports flies, and `vdm_step` moves its frame, too. 0: the host moves the frame
   and gives its angular velocity to `vdm_push_spin`.
   */
  uint32_t flight;
  /*
   Of the separated solution only the first so many terms; 0: all.
   */
  uint32_t terms;
  /*
   Sub-steps of a step at large displacements; 0: those the file was built with.
   */
  uint32_t substeps;
  /*
   Modes that are stepped of a file with live regions; 0: 32, or all of fewer.
   */
  uint32_t modes;
  /*
   Relative error of a trajectory that `VDM_AUTO` accepts.
   */
  double tolerance;
  /*
   Step in s; 0: the file's.
   */
  double time_step;
  /*
   Factor on the stiffness of the whole body.
   */
  double stiffness;
  /*
   Factor on the density of the whole body.
   */
  double density;
  /*
   Rayleigh damping by mass, in 1/s; negative: the file's.
   */
  double alpha;
  /*
   Rayleigh damping by stiffness, in s; negative: the file's.
   */
  double beta;
  /*
   An unloaded body whose state sums up to less is put at rest.
   */
  double rest_below;
  /*
   Numerical viscosity of strain rows at large displacements; 0 keeps the energy exactly.
   */
  double viscosity;
} VdmOptions;

/*
 Sizes of the memory to lend, and counts of the file.
 */
typedef struct VdmNeeds {
  /*
   Bytes for the body, aligned to 16, for as long as it is used.
   */
  size_t memory;
  /*
   Modes; of a file with live regions those that are stepped.
   */
  uint32_t modes;
  /*
   Nodes of the body; those of the surface come first.
   */
  uint32_t nodes;
  /*
   Nodes of the surface.
   */
  uint32_t surface_nodes;
  /*
   Nodes that can be loaded; they come first.
   */
  uint32_t load_nodes;
  /*
   Triangles of the surface.
   */
  uint32_t triangles;
  /*
   Triangles that can be touched; they come first.
   */
  uint32_t load_triangles;
  /*
   Probes.
   */
  uint32_t probes;
  /*
   Load patterns.
   */
  uint32_t patterns;
  /*
   Live parameters.
   */
  uint32_t parameters;
  /*
   Step, in s.
   */
  double time_step;
} VdmNeeds;

/*
 Mass, centre and moments of inertia of a free body.
 */
typedef struct VdmRigidBody {
  /*
   In kg.
   */
  double mass;
  /*
   Its centre in m, in the coordinates of the file.
   */
  double centre[3];
  /*
   Principal moments of inertia about the centre, in kg m².
   */
  double moments[3];
  /*
   The principal axes in the coordinates of the file, one a row.
   */
  double axes[3][3];
} VdmRigidBody;

/*
 The rigid motion of a free body.
 */
typedef struct VdmMotion {
  /*
   Position of the centre in space, in m.
   */
  double position[3];
  /*
   Orientation: a quaternion of length one, the real part first, that turns directions of the
   body into those of space.
   */
  double attitude[4];
  /*
   Momentum in space, in kg m/s.
   */
  double momentum[3];
  /*
   Angular momentum about the centre, in space, in kg m²/s.
   */
  double angular_momentum[3];
} VdmMotion;

/*
 A place: a list of nodes with weights, and a radius; or a frame of the file.
 */
typedef struct VdmPlace {
  /*
   Number of nodes, 1 to `VDM_MAX_PLACE_NODES`; 0 of a frame.
   */
  uint32_t count;
  /*
   The frame, or `VDM_NO_FRAME`. No file has frames yet, so others are refused.
   */
  uint32_t frame;
  /*
   The nodes; those behind `count` do not matter.
   */
  uint32_t nodes[VDM_MAX_PLACE_NODES];
  /*
   Their weights, which sum to 1.
   */
  double weights[VDM_MAX_PLACE_NODES];
  /*
   Radius in m; 0 of a point. This version refuses a positive one.
   */
  double radius;
  /*
   Position at rest, in m, as `vdm_locate` found it.
   */
  double position[3];
  /*
   Distance from the point asked for, in m.
   */
  double distance;
} VdmPlace;

/*
 A row of the table of quantities.
 */
typedef struct VdmQuantity {
  /*
   Its name.
   */
  char name[24];
  /*
   Its unit.
   */
  char unit[8];
  /*
   Unit of its velocity; empty where it has none.
   */
  char rate_unit[8];
  /*
   Not 0: one number is all of it.
   */
  uint32_t scalar;
} VdmQuantity;

/*
 Options of a world. Fill it with `vdm_default_world_options` first.
 */
typedef struct VdmWorldOptions {
  /*
   Acceleration of gravity in space, in m/s², of members that fly and of rigid members.
   */
  double gravity[3];
  /*
   Nodes and triangles are paired up to this distance, in m; 0: a fiftieth of the smallest member.
   */
  double reach;
  /*
   Largest change of a displacement in the last sweep, in m; 0: 1e-9 of the smallest member.
   */
  double tolerance;
  /*
   Share of an overlap that a step takes back, of what is above 1e-4 of the size of the smallest member.
   */
  double recover;
  /*
   Most sweeps of a step.
   */
  uint32_t sweeps;
  /*
   Contacts for which there is room. Of more the deepest are kept.
   */
  uint32_t contacts;
  /*
   Contacts near each contact for which there is room, of bodies whose files have a contact patch.
   */
  uint32_t near;
} VdmWorldOptions;

/*
 A member of a world: a body, or a rigid body within a surface. Set all of it to zero first.
 */
typedef struct VdmMember {
  /*
   A body; null: a rigid member.
   */
  struct VdmBody *body;
  /*
   Nodes of a rigid member in its own coordinates, three numbers each, in m.
   */
  const double *nodes;
  /*
   Its triangles, three nodes each, counterclockwise from outside.
   */
  const uint32_t *triangles;
  /*
   Number of nodes.
   */
  size_t n_nodes;
  /*
   Number of triangles.
   */
  size_t n_triangles;
  /*
   Mass and moments of a rigid member that moves; a mass of 0: the host leads it.
   */
  struct VdmRigidBody mass;
  /*
   Of a rigid member that moves, its motion. Of a body with supports, and of a rigid member that the host
   leads, `position` and `attitude` are the place of the origin of its coordinates and its rotation. A
   body that flies has a motion of its own. An attitude of zeros: not turned.
   */
  struct VdmMotion motion;
} VdmMember;

/*
 Two members that may touch. Set all of it to zero first.
 */
typedef struct VdmTouching {
  /*
   The first member, counted from 0.
   */
  uint32_t first;
  /*
   The second.
   */
  uint32_t second;
  /*
   Members whose nodes are held off the surface of the other: a `VdmNodes`.
   */
  int32_t nodes;
  /*
   Coefficient of Coulomb's friction, 0 or more.
   */
  double friction;
  /*
   Restitution of an impact that is shorter than a step, from 0 to 1.
   */
  double restitution;
} VdmTouching;

/*
 Anchor of a joint on a member. Set all of it to zero first.
 */
typedef struct VdmAnchor {
  /*
   Its kind: a `VdmAnchorKind`.
   */
  int32_t kind;
  /*
   The port, as `vdm_find` counts them.
   */
  uint32_t port;
  /*
   The place.
   */
  struct VdmPlace place;
  /*
   The point of a rigid member in its own coordinates, in m.
   */
  double point[3];
  /*
   Its axes, one a row; zeros: those of the coordinates.
   */
  double axes[3][3];
} VdmAnchor;

/*
 A joint between two members. Set all of it to zero first.
 */
typedef struct VdmJoint {
  /*
   Its kind: a `VdmJointKind`.
   */
  int32_t kind;
  /*
   The first member, counted from 0.
   */
  uint32_t first;
  /*
   The second.
   */
  uint32_t second;
  /*
   Its anchors on the two.
   */
  struct VdmAnchor anchors[2];
  /*
   Length of a cable, in m.
   */
  double length;
  /*
   Compliance of its displacements, in m/N; 0 of a joint that holds.
   */
  double compliance;
  /*
   Force at which it breaks, in N; 0 of a joint that never does.
   */
  double breaks_at;
} VdmJoint;

/*
 Report of the steps of a world.
 */
typedef struct VdmWorldReport {
  /*
   Pairs of nodes and surfaces that were near each other in the last step.
   */
  size_t contacts;
  /*
   Those that carry a force.
   */
  size_t pressed;
  /*
   Most pairs of a step for which there was no room.
   */
  size_t left_out;
  /*
   Sweeps of the solutions of all steps.
   */
  size_t sweeps;
  /*
   Steps whose solution was not within the tolerance.
   */
  size_t not_converged;
  /*
   Deepest overlap at the end of a step, in m; 0 if there is none.
   */
  double worst_gap;
  /*
   Energy that contacts took from the members, in J.
   */
  double energy_given_away;
} VdmWorldReport;

/*
 A contact of the last step, between a node of a member and a point of the surface of another.
 */
typedef struct VdmTouch {
  /*
   Member of the node.
   */
  uint32_t first;
  /*
   Member of the surface.
   */
  uint32_t second;
  /*
   Position of the node in space, in m.
   */
  double position[3];
  /*
   Normal of the surface, outwards.
   */
  double normal[3];
  /*
   Force on the node in space, in N; on the surface acts its opposite.
   */
  double force[3];
  /*
   Normal force, in N; 0 of a node that is near and does not touch.
   */
  double pressure;
  /*
   Gap at the end of the step, in m; below 0 where they overlap.
   */
  double gap;
  /*
   Slip over the step in space, in m.
   */
  double slip[3];
} VdmTouch;

/*
 A joint after the last step.
 */
typedef struct VdmJointState {
  /*
   Force on the first member in space, in N.
   */
  double force[3];
  /*
   Moment on it about its anchor in space, in N m.
   */
  double moment[3];
  /*
   Not 0: it was broken.
   */
  uint32_t broken;
} VdmJointState;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Compares every section of a file with its checksum, which `vdm_bind` does not: it reads all bytes.

 # Safety
 `file` points to `length` bytes, and `text` is null or points to `capacity` bytes.
 */
enum VdmStatus vdm_verify(const uint8_t *file, size_t length, char *text, size_t capacity);

/*
 The `VdmStructure` that the body took; `VDM_AUTO` for null.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
int32_t vdm_structure(const struct VdmBody *body);

/*
 Cost of a step of the body.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `cost` points to a `VdmCost`.
 */
enum VdmStatus vdm_cost(struct VdmBody *body, struct VdmCost *cost);

/*
 Range and present value of a live parameter.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmParameter`.
 */
enum VdmStatus vdm_parameter(struct VdmBody *body, uint32_t parameter, struct VdmParameter *out);

/*
 Sets live parameters, `count` of them, by their numbers in `ids`; the others stay. Velocities stay what
 they are, as far as the modes at the new values hold them. Loads become stale: clear them and add them
 again.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `ids` and `values` point to `count` numbers
 each.
 */
enum VdmStatus vdm_set_parameters(struct VdmBody *body,
                                  const uint32_t *ids,
                                  const double *values,
                                  size_t count);

/*
 Energies of the last change of live parameters of a file with live regions; others do not have them.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmCarried`.
 */
enum VdmStatus vdm_carried(struct VdmBody *body, struct VdmCarried *out);

/*
 Copies a name of the file into `out`, which has `capacity` bytes, with a zero at its end; a longer name is
 cut.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `capacity` bytes.
 */
enum VdmStatus vdm_name(struct VdmBody *body, int32_t kind, uint32_t index, char *out, size_t capacity);

/*
 The number of what has this name, counted from 0; -1 if nothing has.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `name` is null or points to a text with a
 zero at its end.
 */
int32_t vdm_find(struct VdmBody *body, int32_t kind, const char *name);

/*
 Bytes of memory, aligned to 16, to lend for so many instances of a body; 0 for null.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
size_t vdm_batch_bytes(const struct VdmBody *body, size_t instances);

/*
 Makes instances of the elastic motion of a body, all at rest and without loads, in lent memory. `*batch`
 is the handle, or null.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `memory` points to `memory_bytes` bytes that
 nobody else uses for as long as the handle is used, and `batch` to a pointer.
 */
enum VdmStatus vdm_batch_bind(struct VdmBody *body,
                              size_t instances,
                              uint8_t *memory,
                              size_t memory_bytes,
                              struct VdmBatch **batch);

/*
 Loads an instance with the loads of the body, in place of what it had; they stay until the next call.

 # Safety
 `batch` is null or a handle of [`vdm_batch_bind`], `body` null or a handle of
 [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_batch_load(struct VdmBatch *batch, struct VdmBody *body, size_t instance);

/*
 Takes the loads of all instances away.

 # Safety
 `batch` is null or a handle of [`vdm_batch_bind`].
 */
enum VdmStatus vdm_batch_clear(struct VdmBatch *batch);

/*
 Gives an instance the state of the body.

 # Safety
 As for [`vdm_batch_load`].
 */
enum VdmStatus vdm_batch_set(struct VdmBatch *batch, struct VdmBody *body, size_t instance);

/*
 Gives the body the state of an instance, from which everything can be read but reactions.

 # Safety
 As for [`vdm_batch_load`].
 */
enum VdmStatus vdm_batch_get(struct VdmBatch *batch, struct VdmBody *body, size_t instance);

/*
 [`vdm_batch_get`] for an instance whose last step was one under the loads that the body has now: stress
 and displacement show what the modes leave out of the answer to them, and reactions can be read, which are
 refused after [`vdm_batch_get`].

 # Safety
 As for [`vdm_batch_load`].
 */
enum VdmStatus vdm_batch_get_under(struct VdmBatch *batch, struct VdmBody *body, size_t instance);

/*
 Steps all instances `steps` times; `found` tells how many move, rest and were refused in the last step. An
 instance that was refused keeps its state; the answer is then `VDM_STEP`, and the others have moved.

 # Safety
 As for [`vdm_batch_load`]; `found` points to a `VdmBatchStatus`.
 */
enum VdmStatus vdm_batch_step(struct VdmBatch *batch,
                              struct VdmBody *body,
                              uint64_t steps,
                              struct VdmBatchStatus *found);

/*
 The result of the last step for an instance: `VDM_OK`, `VDM_AT_REST`, or `VDM_STEP` if it was refused.

 # Safety
 As for [`vdm_batch_load`].
 */
enum VdmStatus vdm_batch_status(struct VdmBatch *batch, struct VdmBody *body, size_t instance);

/*
 Carries the states of all instances over to the parameters that the body has now. Their loads are stale:
 clear them. Instances of a body with live regions keep the parameters at which they were made, and every
 call is refused while the body has others (`VDM_BIND`).

 # Safety
 As for [`vdm_batch_load`].
 */
enum VdmStatus vdm_batch_carry(struct VdmBatch *batch, struct VdmBody *body);

/*
 The version of the interface that this library has.
 */
uint32_t vdm_abi(void);

/*
 The meaning of a status, in words; never null.
 */
const char *vdm_status_text(int32_t status);

/*
 The file as it was built: single precision, room for 16 contacts, with residual flexibility, flying if it
 has no supports.

 # Safety
 `options` is null or points to a `VdmOptions`.
 */
void vdm_default_options(struct VdmOptions *options);

/*
 The memory that a body of this file needs under these options (null: the default ones).

 `text`, of `capacity` bytes, receives what is wrong in words if it is not null.

 # Safety
 `file` points to `length` bytes, `options` is null or points to a `VdmOptions`, `needs` points to a
 `VdmNeeds`, and `text` is null or points to `capacity` bytes.
 */
enum VdmStatus vdm_measure(const uint8_t *file,
                           size_t length,
                           const struct VdmOptions *options,
                           struct VdmNeeds *needs,
                           char *text,
                           size_t capacity);

/*
 Binds a body at rest, without loads, in lent memory. `*body` is the handle, or null.

 # Safety
 `file` points to `length` bytes and `memory` to `memory_bytes` bytes that nobody else uses; both stay
 where they are, and the file unchanged, for as long as the handle is used. `options` is null or points to
 a `VdmOptions`, `body` points to a pointer, and `text` is null or points to `capacity` bytes.
 */
enum VdmStatus vdm_bind(const uint8_t *file,
                        size_t length,
                        const struct VdmOptions *options,
                        uint8_t *memory,
                        size_t memory_bytes,
                        struct VdmBody **body,
                        char *text,
                        size_t capacity);

/*
 The words of the last call of this body that was refused; never null.

 # Safety
 `body` is null or a handle of [`vdm_bind`]. The text lives until the next call of the body.
 */
const char *vdm_message(const struct VdmBody *body);

/*
 Mass, centre and moments of inertia of a body without supports, at the density it has now.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmRigidBody`.
 */
enum VdmStatus vdm_rigid_body(struct VdmBody *body, struct VdmRigidBody *out);

/*
 Puts a body that flies where the file has it, with a velocity of its centre in m/s and an angular velocity
 in rad/s. Its elastic motion stays.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `velocity` and `spin` point to three numbers
 each.
 */
enum VdmStatus vdm_throw(struct VdmBody *body, const double *velocity, const double *spin);

/*
 The motion in space of a body that flies.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmMotion`.
 */
enum VdmStatus vdm_motion(struct VdmBody *body, struct VdmMotion *out);

/*
 Puts a body that flies elsewhere, or lets it move otherwise. The attitude is brought to length one. Loads
 stay, and so does the elastic motion.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `motion` points to a `VdmMotion`.
 */
enum VdmStatus vdm_set_motion(struct VdmBody *body, const struct VdmMotion *motion);

/*
 The motion in space at the end of the coming step under the loads at hand.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmMotion`.
 */
enum VdmStatus vdm_ahead(struct VdmBody *body, struct VdmMotion *out);

/*
 Position in m, or velocity in m/s, in space of a place of a body that flies, deformed as it is; three
 numbers.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `out` to
 three numbers.
 */
enum VdmStatus vdm_in_space(struct VdmBody *body, const struct VdmPlace *place, int32_t field, double *out);

/*
 The place of the loadable surface at rest that is nearest to a point. A search over all triangles: `O(n)`.
 A point further away than the body is large (`VDM_LOAD`) is most likely in another unit.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `point` points to three numbers, `place` to a
 `VdmPlace`.
 */
enum VdmStatus vdm_locate(struct VdmBody *body, const double *point, struct VdmPlace *place);

/*
 The place that is a loadable node; no search.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`.
 */
enum VdmStatus vdm_at_node(struct VdmBody *body, uint32_t node, struct VdmPlace *place);

/*
 Takes all loads away.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_clear(struct VdmBody *body);

/*
 Adds a force in N at a place. It acts in every step until [`vdm_clear`]; on a body that flies it is a
 force of space, for one step.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `force` to
 three numbers.
 */
enum VdmStatus vdm_push(struct VdmBody *body, const struct VdmPlace *place, const double *force);

/*
 Adds a force in N that changes within a step: `force` times the four `amplitudes` at [`vdm_instants`]. A
 body that flies takes the mean of start and end.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `force` to
 three numbers, and `amplitudes` to four.
 */
enum VdmStatus vdm_push_staged(struct VdmBody *body,
                               const struct VdmPlace *place,
                               const double *force,
                               const double *amplitudes);

/*
 Adds a force in N that goes linearly from `start` to `end` over one step.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `start` and
 `end` to three numbers.
 */
enum VdmStatus vdm_push_ramp(struct VdmBody *body,
                             const struct VdmPlace *place,
                             const double *start,
                             const double *end);

/*
 Adds a load pattern, times an amplitude. It acts in every step until [`vdm_clear`]; on a body that flies
 it turns with the body and acts for one step.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_push_pattern(struct VdmBody *body, uint32_t pattern, double amplitude);

/*
 Adds a load pattern that changes within a step: times the four `amplitudes` at [`vdm_instants`].

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `amplitudes` points to four numbers.
 */
enum VdmStatus vdm_push_pattern_staged(struct VdmBody *body, uint32_t pattern, const double *amplitudes);

/*
 Adds a load pattern whose amplitude goes linearly from `start` to `end` over one step.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_push_pattern_ramp(struct VdmBody *body, uint32_t pattern, double start, double end);

/*
 Adds the inertia of a base that moves so, in its own axes: acceleration in m/s², angular velocity in rad/s
 and angular acceleration in rad/s², three numbers each. It acts in every step until [`vdm_clear`].

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), each pointer points to three numbers.
 */
enum VdmStatus vdm_push_base(struct VdmBody *body,
                             const double *acceleration,
                             const double *angular_velocity,
                             const double *angular_acceleration);

/*
 Adds the centrifugal forces of a body without supports that its host moves (`VdmOptions.flight` = 0), for
 a step in which its angular velocity in rad/s, in its own axes, goes from `before` to `after`.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `before` and `after` point to three numbers.
 */
enum VdmStatus vdm_push_spin(struct VdmBody *body, const double *before, const double *after);

/*
 Pulls a body that flies at its centre with a force in N, in the directions of space, for one step: gravity
 is the mass times its acceleration.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `force` points to three numbers.
 */
enum VdmStatus vdm_pull(struct VdmBody *body, const double *force);

/*
 Instants of a step at which a load that changes is asked for, as fractions of the step; four numbers, of
 which those past the stages of the scheme are 0.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `instants` points to four numbers.
 */
enum VdmStatus vdm_instants(struct VdmBody *body, double *instants);

/*
 Keeps the loads as they are, for a body bound with `VdmOptions.keep_loads`: those that stay, in a loop
 that adds others to them in each step.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_keep_loads(struct VdmBody *body);

/*
 The loads become those that were kept.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_recall_loads(struct VdmBody *body);

/*
 A row of the table of what can be read of a body. Numbers count from 0 without a gap and stay from version
 to version; new ones come last. `VDM_ARGUMENT` past the last one.

 # Safety
 `out` is null or points to a `VdmQuantity`.
 */
enum VdmStatus vdm_quantity(uint32_t quantity, struct VdmQuantity *out);

/*
 The number of the quantity that has this name; -1 if none has.

 # Safety
 `name` is null or points to a text with a zero at its end.
 */
int32_t vdm_find_quantity(const char *name);

/*
 Number of instances of a quantity in the body, counted from 0; 0 where it does not have it, and for null.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
size_t vdm_count(const struct VdmBody *body, uint32_t quantity);

/*
 Numbers of each of a quantity; 0 for null.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
size_t vdm_length(const struct VdmBody *body, uint32_t quantity);

/*
 Reads a quantity: [`vdm_length`] numbers. `field` is `VDM_DISPLACEMENT` of all that has no velocity. A
 point is read at a place, by [`vdm_point`].

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
 */
enum VdmStatus vdm_read(struct VdmBody *body,
                        uint32_t quantity,
                        size_t index,
                        int32_t field,
                        double *out,
                        size_t numbers);

/*
 The value of a probe.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `value` points to a number.
 */
enum VdmStatus vdm_probe(struct VdmBody *body, uint32_t probe, int32_t field, double *value);

/*
 Displacement or velocity of a place; three numbers.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `out` to
 three numbers.
 */
enum VdmStatus vdm_point(struct VdmBody *body, const struct VdmPlace *place, int32_t field, double *out);

/*
 Displacement or velocity of a node; three numbers.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to three numbers.
 */
enum VdmStatus vdm_node(struct VdmBody *body, uint32_t node, int32_t field, double *out);

/*
 Displacement or velocity of all nodes of the surface, three `float`s a node: as a vertex array wants them.
 For a body in single precision.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers, three a
 node.
 */
enum VdmStatus vdm_surface_f32(struct VdmBody *body, int32_t field, float *out, size_t numbers);

/*
 The same for a body in double precision.

 # Safety
 As for [`vdm_surface_f32`].
 */
enum VdmStatus vdm_surface_f64(struct VdmBody *body, int32_t field, double *out, size_t numbers);

/*
 Displacement or velocity of all nodes, three `float`s a node: as a vertex array wants them. For a body in
 single precision.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers, three a
 node.
 */
enum VdmStatus vdm_whole_f32(struct VdmBody *body, int32_t field, float *out, size_t numbers);

/*
 The same for a body in double precision.

 # Safety
 As for [`vdm_whole_f32`].
 */
enum VdmStatus vdm_whole_f64(struct VdmBody *body, int32_t field, double *out, size_t numbers);

/*
 Displacement or velocity of all nodes of the surface, with the static answer of [`vdm_solve_statics`],
 three `float`s a node: as a vertex array wants them. For a body in single precision.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers, three a
 node.
 */
enum VdmStatus vdm_surface_with_statics_f32(struct VdmBody *body, int32_t field, float *out, size_t numbers);

/*
 The same for a body in double precision.

 # Safety
 As for [`vdm_surface_with_statics_f32`].
 */
enum VdmStatus vdm_surface_with_statics_f64(struct VdmBody *body, int32_t field, double *out, size_t numbers);

/*
 Displacement or velocity of all nodes, with the static answer of [`vdm_solve_statics`], three `float`s a
 node: as a vertex array wants them. For a body in single precision.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers, three a
 node.
 */
enum VdmStatus vdm_whole_with_statics_f32(struct VdmBody *body, int32_t field, float *out, size_t numbers);

/*
 The same for a body in double precision.

 # Safety
 As for [`vdm_whole_with_statics_f32`].
 */
enum VdmStatus vdm_whole_with_statics_f64(struct VdmBody *body, int32_t field, double *out, size_t numbers);

/*
 Solves for the static answer of the whole body to the forces of the last step, of a body bound with
 `VdmOptions.static_field`; worth it only when they have changed.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_solve_statics(struct VdmBody *body);

/*
 Kinetic plus elastic energy, in J.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `value` points to a number.
 */
enum VdmStatus vdm_energy(struct VdmBody *body, double *value);

/*
 Force in N and moment in N m that a support exerts on the body, six numbers into `out`.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to six numbers.
 */
enum VdmStatus vdm_reaction(struct VdmBody *body, uint32_t support, double *out);

/*
 Number of points that the file knows the stress of; 0 for null.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
uint32_t vdm_stress_points(const struct VdmBody *body);

/*
 Node and region of such a point, two numbers into `out`.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to two numbers.
 */
enum VdmStatus vdm_stress_point(struct VdmBody *body, uint32_t point, uint32_t *out);

/*
 Stress in Pa at such a point, six numbers into `out`: xx, yy, zz, xy, yz, zx.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to six numbers.
 */
enum VdmStatus vdm_stress(struct VdmBody *body, uint32_t point, double *out);

/*
 Strain at such a point, in the same order, with the shear strains of the tensor.

 # Safety
 As for [`vdm_stress`].
 */
enum VdmStatus vdm_strain(struct VdmBody *body, uint32_t point, double *out);

/*
 Von Mises' equivalent stress in Pa at such a point.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `value` points to a number.
 */
enum VdmStatus vdm_von_mises(struct VdmBody *body, uint32_t point, double *value);

/*
 The largest energy, in J, that an unloaded body has when it is put at rest.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `value` points to a number.
 */
enum VdmStatus vdm_energy_at_rest(struct VdmBody *body, double *value);

/*
 The map `D` of a step `y + D y + l`, column by column: `(3 modes)²` numbers, or `(2 modes)²` of the exact
 structure.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
 */
enum VdmStatus vdm_increment(struct VdmBody *body, double *out, size_t numbers);

/*
 Positions of the nodes of the surface at rest, in m; three numbers a node.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
 */
enum VdmStatus vdm_positions(struct VdmBody *body, double *out, size_t numbers);

/*
 The triangles of the surface, three nodes each, counter-clockwise from outside.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
 */
enum VdmStatus vdm_triangles(struct VdmBody *body, uint32_t *out, size_t numbers);

/*
 Vertices and triangles of the embedded surface, which is drawn in place of that of the mesh; zeros where a
 file has none.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `vertices` and `triangles` point to a number
 each.
 */
enum VdmStatus vdm_embedded_sizes(struct VdmBody *body, uint32_t *vertices, uint32_t *triangles);

/*
 The triangles of the embedded surface, three vertices each, counter-clockwise from outside.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
 */
enum VdmStatus vdm_embedded_triangles(struct VdmBody *body, uint32_t *out, size_t numbers);

/*
 Positions or displacements at the vertices of the embedded surface, three numbers each, from those at the
 nodes of the surface of the mesh.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `at_nodes` points to `node_numbers` numbers,
 `out` to `numbers` numbers; they do not overlap.
 */
enum VdmStatus vdm_embedded_interpolate(struct VdmBody *body,
                                        const double *at_nodes,
                                        size_t node_numbers,
                                        double *out,
                                        size_t numbers);

/*
 Steps `steps` times under the loads at hand; stops at the first step that is refused. A body that flies
 moves in space, too; its loads act in the first of the steps.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_step(struct VdmBody *body, uint64_t steps);

/*
 Puts the body at rest where the file has it. Loads stay.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_rest(struct VdmBody *body);

/*
 Sets the reduced coordinates and their rates, `VdmNeeds.modes` numbers each, with the acceleration that
 the loads at hand demand.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `zeta` and `zeta_dot` point to `count`
 numbers.
 */
enum VdmStatus vdm_set(struct VdmBody *body, const double *zeta, const double *zeta_dot, size_t count);

/*
 The reduced coordinates and their rates, `VdmNeeds.modes` numbers each.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `zeta` and `zeta_dot` point to `count`
 numbers that do not overlap.
 */
enum VdmStatus vdm_coordinates(struct VdmBody *body, double *zeta, double *zeta_dot, size_t count);

/*
 Bytes that [`vdm_save`] writes at most; 0 for null.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
size_t vdm_saved_length(const struct VdmBody *body);

/*
 Writes everything that a step changes as bytes: a tag of 16, which says what they belong to, then
 little-endian numbers. `*written` is how many bytes there are. Loads are not part of it.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `bytes` points to `capacity` bytes, `written`
 to a number.
 */
enum VdmStatus vdm_save(struct VdmBody *body, uint8_t *bytes, size_t capacity, size_t *written);

/*
 Takes back what [`vdm_save`] of a body of the same file and structure has written: `VDM_OK` if every bit
 is as it was saved, `VDM_CARRIED` if the state was saved at other parameters or in the other precision and
 has been carried over. Other bytes are refused, and change nothing.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `bytes` points to `length` bytes.
 */
enum VdmStatus vdm_restore(struct VdmBody *body, const uint8_t *bytes, size_t length);

/*
 The displacement of each of `count` places, at most `VdmOptions.places`, at the end of the coming step for
 a force of 1 N at each of them: `w` of `3 count` rows and columns, row by row, in m/N. Not for the block
 structure.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `places` points to `count` places, `w` to `9
 count²` numbers.
 */
enum VdmStatus vdm_compliance(struct VdmBody *body, const struct VdmPlace *places, size_t count, double *w);

/*
 Predicts `count` places, at most `VdmOptions.places`, at the end of the coming step if nothing acts
 but the loads at hand: the displacement of each, three numbers a place. The body stays as it is.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `places` points to `count` places, and `out`
 to `3 count` numbers.
 */
enum VdmStatus vdm_free_motion(struct VdmBody *body,
                               const struct VdmPlace *places,
                               size_t count,
                               double *out);

/*
 A world without gravity, with room for 256 contacts.

 # Safety
 `options` is null or points to a `VdmWorldOptions`.
 */
void vdm_default_world_options(struct VdmWorldOptions *options);

/*
 Bytes of memory, aligned to 16, to lend to a world of these members, pairs and joints. The bodies are in
 one precision and of one time step. `options` null: the default ones.

 `text`, of `capacity` bytes, receives what is wrong in words if it is not null.

 # Safety
 Each list points to as many values as are said, and what a member points to is as
 [`vdm_world_bind`] asks for; `options` is null or points to a `VdmWorldOptions`, `bytes` to a number, and
 `text` is null or points to `capacity` bytes.
 */
enum VdmStatus vdm_world_measure(const struct VdmMember *members,
                                 size_t member_count,
                                 const struct VdmTouching *pairs,
                                 size_t pair_count,
                                 const struct VdmJoint *joints,
                                 size_t joint_count,
                                 const struct VdmWorldOptions *options,
                                 size_t *bytes,
                                 char *text,
                                 size_t capacity);

/*
 Makes a world in lent memory. Joints hold the members as they stand. `*world` is the handle, or null. The
 lists are copied; bodies, and nodes and triangles of rigid members, are not.

 # Safety
 Each list points to as many values as are said. Each `body` of a member is null or a handle of
 [`vdm_bind`](crate::vdm_bind); its memory, and the nodes and triangles of rigid members, stay where they
 are for as long as the handle of the world is used, and so do `memory_bytes` bytes at `memory`, which
 nobody else uses. Bodies of the world may be used between its calls, in the same thread. `options` is null
 or points to a `VdmWorldOptions`, `world` points to a pointer, and `text` is null or points to `capacity`
 bytes.
 */
enum VdmStatus vdm_world_bind(const struct VdmMember *members,
                              size_t member_count,
                              const struct VdmTouching *pairs,
                              size_t pair_count,
                              const struct VdmJoint *joints,
                              size_t joint_count,
                              const struct VdmWorldOptions *options,
                              uint8_t *memory,
                              size_t memory_bytes,
                              struct VdmWorld **world,
                              char *text,
                              size_t capacity);

/*
 The words of the last call of this world that was refused; never null.

 # Safety
 `world` is null or a handle of [`vdm_world_bind`]. The text lives until the next call of the world.
 */
const char *vdm_world_message(struct VdmWorld *world);

/*
 Steps all members `steps` times, under the loads on them (`vdm_push` and its kin on bodies,
 [`vdm_world_push`] on rigid members), gravity, contacts and joints. Loads act in the first step. A step
 that is refused ends it.

 # Safety
 `world` is null or a handle of [`vdm_world_bind`], `report` points to a `VdmWorldReport`.
 */
enum VdmStatus vdm_world_step(struct VdmWorld *world, uint64_t steps, struct VdmWorldReport *report);

/*
 Kinetic and elastic energy of members, contacts and joints, in J.

 # Safety
 `world` is null or a handle of [`vdm_world_bind`], `energy` points to a number.
 */
enum VdmStatus vdm_world_energy(struct VdmWorld *world, double *energy);

/*
 The place of the origin of the coordinates of a member in m, three numbers, and its rotation, a quaternion
 of four, the real part first.

 # Safety
 `world` is null or a handle of [`vdm_world_bind`], `position` points to three numbers and `attitude` to
 four.
 */
enum VdmStatus vdm_world_pose(struct VdmWorld *world, uint32_t member, double *position, double *attitude);

/*
 Puts a body with supports elsewhere, or leads a rigid member without a mass there to the end of the coming
 step.

 # Safety
 As for [`vdm_world_pose`]; the numbers are read.
 */
enum VdmStatus vdm_world_lead(struct VdmWorld *world,
                              uint32_t member,
                              const double *position,
                              const double *attitude);

/*
 The motion of a rigid member. That of a body is read by `vdm_motion`.

 # Safety
 `world` is null or a handle of [`vdm_world_bind`], `motion` points to a `VdmMotion`.
 */
enum VdmStatus vdm_world_motion(struct VdmWorld *world, uint32_t member, struct VdmMotion *motion);

/*
 Puts a rigid member elsewhere, or lets it move otherwise; call [`vdm_world_forget`] after it.

 # Safety
 As for [`vdm_world_motion`].
 */
enum VdmStatus vdm_world_set_motion(struct VdmWorld *world, uint32_t member, const struct VdmMotion *motion);

/*
 Pushes a rigid member at a point of space, in m, with a force, in N, in the coming step.

 # Safety
 `world` is null or a handle of [`vdm_world_bind`], `point` and `force` point to three numbers each.
 */
enum VdmStatus vdm_world_push(struct VdmWorld *world,
                              uint32_t member,
                              const double *point,
                              const double *force);

/*
 Position in m, or velocity in m/s, in space of a place of a body, deformed as it is; three numbers. The
 velocity of a body with supports is that of its deformation.

 # Safety
 `world` is null or a handle of [`vdm_world_bind`], `place` points to a `VdmPlace`, `out` to three numbers.
 */
enum VdmStatus vdm_world_in_space(struct VdmWorld *world,
                                  uint32_t member,
                                  const struct VdmPlace *place,
                                  int32_t field,
                                  double *out);

/*
 Contacts of the last step: as many as there is room for are written, and `*count` is the number of all.

 # Safety
 `world` is null or a handle of [`vdm_world_bind`], `touches` is null or points to `capacity` contacts,
 `count` points to a number.
 */
enum VdmStatus vdm_world_touches(struct VdmWorld *world,
                                 struct VdmTouch *touches,
                                 size_t capacity,
                                 size_t *count);

/*
 Force and moment of a joint in the last step.

 # Safety
 `world` is null or a handle of [`vdm_world_bind`], `state` points to a `VdmJointState`.
 */
enum VdmStatus vdm_world_joint(struct VdmWorld *world, uint32_t joint, struct VdmJointState *state);

/*
 Breaks a joint: it holds nothing any more.

 # Safety
 `world` is null or a handle of [`vdm_world_bind`].
 */
enum VdmStatus vdm_world_break(struct VdmWorld *world, uint32_t joint);

/*
 Forgets the contacts of the last step: after a member was put elsewhere.

 # Safety
 `world` is null or a handle of [`vdm_world_bind`].
 */
enum VdmStatus vdm_world_forget(struct VdmWorld *world);

/*
 Numbers of a saved world; 0 for null.

 # Safety
 `world` is null or a handle of [`vdm_world_bind`].
 */
size_t vdm_world_saved_length(struct VdmWorld *world);

/*
 Writes contacts, joints, placements of bodies with supports, and motions of rigid members. With the states
 of the bodies (`vdm_save`) the world goes on from there bit by bit.

 # Safety
 `world` is null or a handle of [`vdm_world_bind`], `saved` points to `length` numbers.
 */
enum VdmStatus vdm_world_save(struct VdmWorld *world, double *saved, size_t length);

/*
 Takes back what [`vdm_world_save`] of a world of the same members, pairs, joints and options wrote.
 Nothing has changed where it is refused.

 # Safety
 As for [`vdm_world_save`].
 */
enum VdmStatus vdm_world_restore(struct VdmWorld *world, const double *saved, size_t length);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* VADEMECUM_H */
