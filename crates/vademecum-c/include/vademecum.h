/*
 * vademecum: steps an elastic body in real time from a vademecum file.
 *
 * Nothing here allocates, locks, or keeps what is not lent to it. A body and the memory it lives in belong to one
 * thread at a time; bodies of one file may live in several threads.
 */

#ifndef VADEMECUM_H
#define VADEMECUM_H

/* Made from crates/vademecum-c/src by its test `header`; do not edit. */

#include <stddef.h>
#include <stdint.h>

/*
 Places that an operator is made for at most.
 */
#define MOST_PLACES 64

/*
 Version of this interface: callers compare it with the header they were compiled with.
 */
#define VDM_ABI 3

/*
 What a call found.
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
   A pointer is null, or an index or a name is not the file's.
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
 What a file names; what calls name `kind`.
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
} VdmNamed;

/*
 How a step is held; what calls name `structure`.
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
 Many instances of a body, behind a handle.
 */
typedef struct VdmBatch VdmBatch;

/*
 A body, behind a handle.
 */
typedef struct VdmBody VdmBody;

/*
 How a body is bound. Fill it with `vdm_default_options` first.
 */
typedef struct VdmOptions {
  /*
   In which numbers the body is stepped: a `VdmPrecision`.
   */
  int32_t precision;
  /*
   How a step is held: a `VdmStructure`.
   */
  int32_t structure;
  /*
   For so many contacts with nodes of their own there is room in the static residual.
   */
  uint32_t contacts;
  /*
   0: outputs show the modes only.
   */
  uint32_t residual;
  /*
   `vdm_compliance` and `vdm_free_motion` take so many places at most; 64 is the largest number.
   */
  uint32_t places;
  /*
   Not 0: there is room for `vdm_keep_loads`.
   */
  uint32_t keep_loads;
  /*
   Of the separated solution only the first so many terms; 0: all.
   */
  uint32_t terms;
  /*
   Sub-steps of a step at large displacements; 0: those the file was built with.
   */
  uint32_t substeps;
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
 How much memory to lend, and what the file holds.
 */
typedef struct VdmNeeds {
  /*
   Bytes for the body, aligned to 16, for as long as it is used.
   */
  size_t memory;
  /*
   Numbers of type `double`, while `vdm_bind` and `vdm_set_parameter` run.
   */
  size_t work;
  /*
   Numbers to lend to `vdm_save`.
   */
  size_t state;
  /*
   Modes.
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
 A place of the surface: three loadable nodes and their shares.
 */
typedef struct VdmPlace {
  /*
   Loadable nodes.
   */
  uint32_t nodes[3];
  /*
   Their shares, which sum to 1.
   */
  double weights[3];
  /*
   Where it is at rest, in m; what `vdm_locate` found.
   */
  double position[3];
  /*
   How far that is from the point asked for, in m.
   */
  double distance;
} VdmPlace;

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
 What the moves of a body cost. Bytes are those of the file, apart from `step_bytes`.
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
 What a step of many instances found.
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
   Where the centre is in space, in m.
   */
  double position[3];
  /*
   How the body is turned: a quaternion of length one, the real part first, that turns directions of the
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

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 The version of the interface that this library has.
 */
uint32_t vdm_abi(void);

/*
 What a status means, in words; never null.
 */
const char *vdm_status_text(int32_t status);

/*
 The file as it was built: single precision, room for 16 contacts, with residual.

 # Safety
 `options` is null or points to a `VdmOptions`.
 */
void vdm_default_options(struct VdmOptions *options);

/*
 How much memory a body of this file needs under these options (null: the default ones).

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
 where they are, and the file unchanged, for as long as the handle is used. `work` points to `work_numbers`
 numbers for the time of the call. `options` is null or points to a `VdmOptions`, `body` points to a
 pointer, and `text` is null or points to `capacity` bytes.
 */
enum VdmStatus vdm_bind(const uint8_t *file,
                        size_t length,
                        const struct VdmOptions *options,
                        uint8_t *memory,
                        size_t memory_bytes,
                        double *work,
                        size_t work_numbers,
                        struct VdmBody **body,
                        char *text,
                        size_t capacity);

/*
 What was wrong with the last call of this body that was refused; never null.

 # Safety
 `body` is null or a handle of [`vdm_bind`]. The text lives until the next call of the body.
 */
const char *vdm_message(const struct VdmBody *body);

/*
 Steps `steps` times under the loads at hand; stops at the first step that is refused.

 # Safety
 `body` is null or a handle of [`vdm_bind`].
 */
enum VdmStatus vdm_step(struct VdmBody *body, uint64_t steps);

/*
 Puts the body at rest, as it was bound. Loads stay.

 # Safety
 `body` is null or a handle of [`vdm_bind`].
 */
enum VdmStatus vdm_rest(struct VdmBody *body);

/*
 The place of the loadable surface at rest that is nearest to a point. A search over all triangles: `O(n)`.

 # Safety
 `body` is null or a handle of [`vdm_bind`], `point` points to three numbers, `place` to a `VdmPlace`.
 */
enum VdmStatus vdm_locate(struct VdmBody *body, const double *point, struct VdmPlace *place);

/*
 Takes all loads away.

 # Safety
 `body` is null or a handle of [`vdm_bind`].
 */
enum VdmStatus vdm_clear_loads(struct VdmBody *body);

/*
 Adds a force in N at a place; it acts in every step until [`vdm_clear_loads`].

 # Safety
 `body` is null or a handle of [`vdm_bind`], `place` points to a `VdmPlace`, `force` to three numbers.
 */
enum VdmStatus vdm_add_contact(struct VdmBody *body, const struct VdmPlace *place, const double *force);

/*
 Adds a load pattern, times an amplitude; it acts in every step until [`vdm_clear_loads`].

 # Safety
 `body` is null or a handle of [`vdm_bind`].
 */
enum VdmStatus vdm_add_pattern(struct VdmBody *body, uint32_t pattern, double amplitude);

/*
 Sets a live parameter. Loads become stale: clear them and add them again.

 # Safety
 `body` is null or a handle of [`vdm_bind`]; `work` points to `work_numbers` numbers.
 */
enum VdmStatus vdm_set_parameter(struct VdmBody *body,
                                 uint32_t parameter,
                                 double value,
                                 double *work,
                                 size_t work_numbers);

/*
 The value of a probe.

 # Safety
 `body` is null or a handle of [`vdm_bind`]; `value` points to a number.
 */
enum VdmStatus vdm_probe(struct VdmBody *body, uint32_t probe, int32_t field, double *value);

/*
 Displacement or velocity of a place of the surface; three numbers.

 # Safety
 `body` is null or a handle of [`vdm_bind`], `place` points to a `VdmPlace`, `out` to three numbers.
 */
enum VdmStatus vdm_point(struct VdmBody *body, const struct VdmPlace *place, int32_t field, double *out);

/*
 Displacement or velocity of a node; three numbers.

 # Safety
 `body` is null or a handle of [`vdm_bind`]; `out` points to three numbers.
 */
enum VdmStatus vdm_node(struct VdmBody *body, uint32_t node, int32_t field, double *out);

/*
 Displacement or velocity of all nodes of the surface, three `float`s a node: as a vertex array wants them.
 For a body in single precision.

 # Safety
 `body` is null or a handle of [`vdm_bind`]; `out` points to `numbers` numbers, three a node.
 */
enum VdmStatus vdm_surface_f32(struct VdmBody *body, int32_t field, float *out, size_t numbers);

/*
 The same for a body in double precision.

 # Safety
 As for [`vdm_surface_f32`].
 */
enum VdmStatus vdm_surface_f64(struct VdmBody *body, int32_t field, double *out, size_t numbers);

/*
 Kinetic plus elastic energy, in J.

 # Safety
 `body` is null or a handle of [`vdm_bind`]; `value` points to a number.
 */
enum VdmStatus vdm_energy(struct VdmBody *body, double *value);

/*
 Copies the state out, every bit of it (in the body's precision); at least `VdmNeeds.state` numbers are
 lent.

 # Safety
 `body` is null or a handle of [`vdm_bind`]; `out` points to `numbers` numbers.
 */
enum VdmStatus vdm_save(struct VdmBody *body, double *out, size_t numbers);

/*
 Takes back what [`vdm_save`] has written.

 # Safety
 `body` is null or a handle of [`vdm_bind`]; `saved` points to `numbers` numbers.
 */
enum VdmStatus vdm_restore(struct VdmBody *body, const double *saved, size_t numbers);

/*
 How far each of `count` places, at most `VdmOptions.places`, moves in the coming step for a force of 1 N
 held at each: `w` receives `(3 count)²` numbers, row by row, in m/N.

 # Safety
 `body` is null or a handle of [`vdm_bind`], `places` points to `count` places, and `w` to `(3 count)²`
 numbers.
 */
enum VdmStatus vdm_compliance(struct VdmBody *body, const struct VdmPlace *places, size_t count, double *w);

/*
 Copies a name of the file into `out`, which has `capacity` bytes, with a zero at its end; a longer name is
 cut.

 # Safety
 `body` is null or a handle of [`vdm_bind`]; `out` points to `capacity` bytes.
 */
enum VdmStatus vdm_name(struct VdmBody *body, int32_t kind, uint32_t index, char *out, size_t capacity);

/*
 The number of what has this name, counted from 0; -1 if nothing has.

 # Safety
 `body` is null or a handle of [`vdm_bind`]; `name` points to a text with a zero at its end.
 */
int32_t vdm_find(struct VdmBody *body, int32_t kind, const char *name);

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
int32_t vdm_structure(struct VdmBody *body);

/*
 Range and present value of a live parameter.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmParameter`.
 */
enum VdmStatus vdm_parameter(struct VdmBody *body, uint32_t parameter, struct VdmParameter *out);

/*
 Sets all live parameters at once. Loads become stale: clear them and add them again.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `values` points to `count` numbers, `work` to
 `work_numbers`.
 */
enum VdmStatus vdm_set_parameters(struct VdmBody *body,
                                  const double *values,
                                  size_t count,
                                  double *work,
                                  size_t work_numbers);

/*
 What the moves of the body cost.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `cost` points to a `VdmCost`.
 */
enum VdmStatus vdm_cost(struct VdmBody *body, struct VdmCost *cost);

/*
 Bytes of memory, aligned to 16, to lend for so many instances of a body; 0 for null.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
size_t vdm_batch_bytes(const struct VdmBody *body, size_t instances);

/*
 Makes instances of a body, all at rest and without loads, in lent memory. `*batch` is the handle, or null.

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
 Gives the body the state of an instance, from which everything can be read.

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
 What the last step found of an instance.

 # Safety
 As for [`vdm_batch_load`].
 */
enum VdmStatus vdm_batch_status(struct VdmBatch *batch, struct VdmBody *body, size_t instance);

/*
 Carries the states of all instances over to the parameters that the body has now. Their loads are stale:
 clear them.

 # Safety
 As for [`vdm_batch_load`].
 */
enum VdmStatus vdm_batch_carry(struct VdmBatch *batch, struct VdmBody *body);

/*
 Displacement or velocity of all nodes, three `float`s a node. For a body in single precision.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
 */
enum VdmStatus vdm_body_f32(struct VdmBody *body, int32_t field, float *out, size_t numbers);

/*
 The same for a body in double precision.

 # Safety
 As for [`vdm_body_f32`].
 */
enum VdmStatus vdm_body_f64(struct VdmBody *body, int32_t field, double *out, size_t numbers);

/*
 Where the nodes of the surface are at rest, in m; three numbers a node.

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
 The largest energy, in J, that an unloaded body has when it is put at rest.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `value` points to a number.
 */
enum VdmStatus vdm_energy_at_rest(struct VdmBody *body, double *value);

/*
 Bytes of memory, aligned to 16, to lend for the static answer of the whole body; 0 where the file does not
 have it (`static_fields` of the problem file).

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
size_t vdm_static_bytes(struct VdmBody *body);

/*
 Lends memory for the static answer of the whole body, for as long as the body is used.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `memory` points to `memory_bytes` bytes that
 nobody else uses.
 */
enum VdmStatus vdm_static_lend(struct VdmBody *body, uint8_t *memory, size_t memory_bytes);

/*
 Solves for the static answer to the forces of the last step; worth it only when they have changed.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_static_solve(struct VdmBody *body);

/*
 [`vdm_surface_f32`](crate::vdm_surface_f32) with the static answer that was solved for.

 # Safety
 As for [`vdm_body_f32`].
 */
enum VdmStatus vdm_static_surface_f32(struct VdmBody *body, int32_t field, float *out, size_t numbers);

/*
 The same for a body in double precision.

 # Safety
 As for [`vdm_body_f32`].
 */
enum VdmStatus vdm_static_surface_f64(struct VdmBody *body, int32_t field, double *out, size_t numbers);

/*
 [`vdm_body_f32`] with the static answer that was solved for.

 # Safety
 As for [`vdm_body_f32`].
 */
enum VdmStatus vdm_static_body_f32(struct VdmBody *body, int32_t field, float *out, size_t numbers);

/*
 The same for a body in double precision.

 # Safety
 As for [`vdm_body_f32`].
 */
enum VdmStatus vdm_static_body_f64(struct VdmBody *body, int32_t field, double *out, size_t numbers);

/*
 Force in N and moment in N m that a support exerts on the body, six numbers into `out`.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to six numbers.
 */
enum VdmStatus vdm_reaction(struct VdmBody *body, uint32_t support, double *out);

/*
 How many points the file knows the stress of; 0 for null.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
uint32_t vdm_stress_points(struct VdmBody *body);

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
 Von Mises' equivalent stress in Pa of six numbers of [`vdm_stress`]; not a number for null.

 # Safety
 `stress` is null or points to six numbers.
 */
double vdm_von_mises(const double *stress);

/*
 Mass, centre and moments of inertia of a free body, at the density it has now; `VDM_OUTPUT` for a body
 with supports, as from all calls that begin with `vdm_flight`.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmRigidBody`.
 */
enum VdmStatus vdm_flight_mass(struct VdmBody *body, struct VdmRigidBody *out);

/*
 Puts a free body where the file has it, with a velocity of its centre in m/s and an angular velocity in
 rad/s. Its elastic motion stays.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `velocity` and `spin` point to three
 numbers each.
 */
enum VdmStatus vdm_flight_throw(struct VdmBody *body, const double *velocity, const double *spin);

/*
 The rigid motion.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmMotion`.
 */
enum VdmStatus vdm_flight_motion(struct VdmBody *body, struct VdmMotion *out);

/*
 Puts the body elsewhere, or lets it move otherwise. The attitude is brought to length one. What pushes the
 body stays, and so does its elastic motion.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `motion` points to a `VdmMotion`.
 */
enum VdmStatus vdm_flight_set_motion(struct VdmBody *body, const struct VdmMotion *motion);

/*
 Where the rigid motion will be at the end of the coming step under what pushes it so far.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmMotion`.
 */
enum VdmStatus vdm_flight_ahead(struct VdmBody *body, struct VdmMotion *out);

/*
 Pushes at a place with a force in N, in the directions of space, for the coming [`vdm_flight_step`].

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `force`
 to three numbers.
 */
enum VdmStatus vdm_flight_add_contact(struct VdmBody *body,
                                      const struct VdmPlace *place,
                                      const double *force);

/*
 Adds a load pattern, which turns with the body, times an amplitude, for the coming [`vdm_flight_step`].

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_flight_add_pattern(struct VdmBody *body, uint32_t pattern, double amplitude);

/*
 Pulls at the centre with a force in N, in the directions of space, for the coming [`vdm_flight_step`]:
 gravity is the mass times its acceleration.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `force` points to three numbers.
 */
enum VdmStatus vdm_flight_pull(struct VdmBody *body, const double *force);

/*
 One step of both motions, under what was added since the last one, and takes that away.
 [`vdm_step`](crate::vdm_step), in contrast, leaves the rigid motion to whoever moves the body.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_flight_step(struct VdmBody *body);

/*
 Where a place is in space, deformed as it is, in m; three numbers.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `out`
 to three numbers.
 */
enum VdmStatus vdm_flight_point(struct VdmBody *body, const struct VdmPlace *place, double *out);

/*
 Velocity of a place in space, in m/s; three numbers.

 # Safety
 As for [`vdm_flight_point`].
 */
enum VdmStatus vdm_flight_velocity(struct VdmBody *body, const struct VdmPlace *place, double *out);

/*
 The place that is a loadable node; no search.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`.
 */
enum VdmStatus vdm_at_node(struct VdmBody *body, uint32_t node, struct VdmPlace *place);

/*
 Instants of a step at which a load that changes is asked for, as fractions of the step; four numbers, of
 which those past the stages of the scheme are 0.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `instants` points to four numbers.
 */
enum VdmStatus vdm_instants(struct VdmBody *body, double *instants);

/*
 Adds a force in N that changes within a step: `force` times the four `amplitudes` at [`vdm_instants`].

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `force` to
 three numbers, and `amplitudes` to four.
 */
enum VdmStatus vdm_add_contact_staged(struct VdmBody *body,
                                      const struct VdmPlace *place,
                                      const double *force,
                                      const double *amplitudes);

/*
 Adds a load pattern that changes within a step: times the four `amplitudes` at [`vdm_instants`].

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `amplitudes` points to four numbers.
 */
enum VdmStatus vdm_add_pattern_staged(struct VdmBody *body, uint32_t pattern, const double *amplitudes);

/*
 Adds the inertia of a base that moves so, in its own axes: acceleration in m/s², angular velocity in rad/s
 and angular acceleration in rad/s², three numbers each. It acts in every step until `vdm_clear_loads`.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), each pointer points to three numbers.
 */
enum VdmStatus vdm_add_base(struct VdmBody *body,
                            const double *acceleration,
                            const double *angular_velocity,
                            const double *angular_acceleration);

/*
 Adds a force in N that goes linearly from `start` to `end` over one step.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `start` and
 `end` to three numbers.
 */
enum VdmStatus vdm_add_contact_ramp(struct VdmBody *body,
                                    const struct VdmPlace *place,
                                    const double *start,
                                    const double *end);

/*
 Adds a load pattern whose amplitude goes linearly from `start` to `end` over one step.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_add_pattern_ramp(struct VdmBody *body, uint32_t pattern, double start, double end);

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
 Bytes of memory, aligned to 16, and numbers of work that the modes of a dense step want; zeros for a body
 without the block structure.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `memory_bytes` and `work_numbers` each point
 to a number.
 */
enum VdmStatus vdm_modal_needs(struct VdmBody *body, size_t *memory_bytes, size_t *work_numbers);

/*
 Takes the dense step of a body with the block structure apart into independent modes, at the parameters it
 has now. What the modes do not share is left out, and refused above `tolerance` (1e-5 is usual).

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `memory` points to `memory_bytes` bytes that
 nobody else uses for as long as the body is used, `work` to `work_numbers` numbers for the call.
 */
enum VdmStatus vdm_modal_bind(struct VdmBody *body,
                              double tolerance,
                              uint8_t *memory,
                              size_t memory_bytes,
                              double *work,
                              size_t work_numbers);

/*
 Steps `steps` times, all under the loads at hand, in the modes of [`vdm_modal_bind`]. Ten steps in a call
 are cheaper than ten of `vdm_step`, one is not.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_modal_march(struct VdmBody *body, size_t steps);

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
 Gives a body the state of another one of the same file, precision and structure, whose step in time may
 differ: displacement, velocity and acceleration stay what they are.

 # Safety
 `to` and `from` are null or handles of [`vdm_bind`](crate::vdm_bind).
 */
enum VdmStatus vdm_carry(struct VdmBody *to, const struct VdmBody *from);

/*
 The map `D` of a step `y + D y + l`, column by column: `(3 modes)²` numbers, or `(2 modes)²` of the exact
 structure.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
 */
enum VdmStatus vdm_increment(struct VdmBody *body, double *out, size_t numbers);

/*
 Where `count` places, at most `VdmOptions.places`, will be at the end of the coming step if nothing acts
 but the loads at hand: the displacement of each, three numbers a place. The body stays as it is.

 # Safety
 `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `places` points to `count` places, and `out`
 to `3 count` numbers.
 */
enum VdmStatus vdm_free_motion(struct VdmBody *body,
                               const struct VdmPlace *places,
                               size_t count,
                               double *out);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* VADEMECUM_H */
