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
 Version of this interface: callers compare it with the header they were compiled with.
 */
#define VDM_ABI 1

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
} VdmNamed;

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
   For so many contacts with nodes of their own there is room in the static residual.
   */
  uint32_t contacts;
  /*
   0: outputs show the modes only.
   */
  uint32_t residual;
  /*
   An unloaded body whose state sums up to less is put at rest.
   */
  double rest_below;
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
   Numbers that `vdm_save` writes.
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
 Single precision, room for 16 contacts, with residual.

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
 Copies the state out, every bit of it (in the body's precision); `VdmNeeds.state` numbers.

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
 How far each of `count` places, at most 64, moves in the coming step for a force of 1 N held at each: `w`
 receives `(3 count)²` numbers, row by row, in m/N.

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

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* VADEMECUM_H */
