/* pliant.h: the plugin interface (ABI), for C11 and C++17.
 *
 * A plugin is a shared library that exports one symbol, `pliant_entry`. Quantities are in SI units, angles in rad.
 * Almost every struct starts with `size`, its sizeof as its author compiled it, so that a minor release may append fields.
 * A field or function that is no longer used keeps its place and is marked "reserved" or "deprecated".
 *
 * The thread class stands in brackets after each function:
 *   [main]   one thread for the plugin's life; may allocate, read files and block briefly
 *   [worker] one call per instance at a time; may allocate and take seconds
 *   [sim]    inside a step; several calls of one instance at once, on disjoint nodes; must not allocate, lock or do I/O
 *   [servo]  one call at a time, 1-4 kHz, hard deadline; as [sim], and must not loop over a mesh
 *   [any]    from any thread, at the same time as any other call
 * `& active` / `& !active`: only between `activate` and `deactivate`, or only outside.
 *
 * A pointer is borrowed until the call returns unless its comment says longer. Only a pointer marked "or NULL" may be null.
 */
#ifndef PLIANT_H
#define PLIANT_H
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

#define PLIANT_ABI_MAJOR 1u
#define PLIANT_ABI_MINOR 1u

#if defined(_WIN32)
#define PLIANT_EXPORT __declspec(dllexport)
#else
#define PLIANT_EXPORT __attribute__((visibility("default")))
#endif

/* ---- status ---------------------------------------------------------------------------------------------------- */
typedef int32_t pliant_status;
#define PLIANT_OK            0
#define PLIANT_BAD_ARGUMENT -1
#define PLIANT_UNSUPPORTED  -2
#define PLIANT_DIVERGED     -3  /* a result is not finite */
#define PLIANT_IO           -4
#define PLIANT_PANICKED     -5  /* a panic or exception was caught; the host stops calling the instance */
#define PLIANT_TOO_SMALL    -6  /* a buffer is too small; the counts say what is needed */
/* Codes of -1000 and below are the plugin's own. */

/* Severity of a message. */
#define PLIANT_INFO    0u
#define PLIANT_WARNING 1u
#define PLIANT_ERROR   2u

/* ---- entry ------------------------------------------------------------------------------------------------------ */
typedef struct pliant_host {          /* what the host offers a plugin; outlives every instance it is handed to */
  size_t size;
  uint32_t abi_major, abi_minor;
  void *data;                         /* the host's own */
  /* Passes one line of text to the host, which copies its first 255 bytes and never waits. [any] */
  void (*report)(const struct pliant_host *, uint32_t severity, const char *text);
} pliant_host;

#define PLIANT_PARAM_NUMBER 1u /* a double in [min, max], in `unit` */
#define PLIANT_PARAM_CHOICE 2u /* one of `choices`, handed over as its index */
#define PLIANT_PARAM_TEXT   3u /* UTF-8, empty by default */
#define PLIANT_PARAM_PATH   4u /* a file; the host makes a relative path absolute against the scene's folder; empty by default */
#define PLIANT_PARAM_TABLE  5u /* rows x columns of finite doubles; `choices` names the columns, in order; empty by default */

#define PLIANT_PARAM_FIELD 1u  /* flag of a number of a material: it may differ from element to element, see pliant_batch.fields */

typedef struct pliant_param { /* declaration of one parameter; the struct has no `size`: see pliant_descriptor.param_size */
  uint32_t kind;              /* PLIANT_PARAM_... */
  const char *key;            /* kebab-case, as in a scene file */
  const char *unit;           /* SI text: "Pa", "kg/m^3", "1" */
  const char *summary;        /* one line */
  double min, max, fallback;  /* range of a number, in `unit`, and the default; of a choice, `fallback` is the index */
  const char *choices;        /* "one|two|three", or NULL */
  uint32_t flags;             /* since 1.1: PLIANT_PARAM_FIELD, or 0 */
} pliant_param;

#define PLIANT_KIND_GRID     1u
#define PLIANT_KIND_MATERIAL 2u
#define PLIANT_KIND_DEVICE   3u
#define PLIANT_KIND_CONTACT_LAW 4u /* since 1.1 */
#define PLIANT_FLAG_REAL_TIME     1u /* [sim] and [servo] calls meet the rules above */
#define PLIANT_FLAG_DETERMINISTIC 2u /* same inputs, same bytes, on the same binary */
#define PLIANT_FLAG_WHOLE_LISTS   4u /* of a material, since 1.1: a call has all elements of its kind, and the host makes one call of the instance
                                      * at a time, as suits a law whose calls have a cost of their own: on a GPU, or through the library of a
                                      * neural network. Not with PLIANT_CAN_FAIL. A host that does not know the flag divides the list between
                                      * calls of several threads, so results must not depend on ranges here either. */

typedef struct pliant_descriptor {    /* what is known of a plugin before an instance exists; lives as long as the library */
  size_t size;
  uint32_t kind, flags;               /* PLIANT_KIND_..., PLIANT_FLAG_... */
  const char *id;                     /* kebab-case; with a reversed domain before it once others use it: "org.lab.springy" */
  const char *name, *version, *summary; /* for people; `version` is the plugin's */
  const pliant_param *params;
  size_t param_count, param_size;     /* param_size: sizeof(pliant_param) as compiled, the distance between parameters */
} pliant_descriptor;

typedef struct pliant_limits {
  size_t size;
  /* Deprecated: s, the time step of the scene. The host still fills it for plugins of 1.0. Do not use it: a substep is shorter
   * and differs from call to call. A material reads `pliant_batch.dt`, a device the `time_ns` of its calls. */
  double dt;
} pliant_limits;

typedef struct pliant_plugin {        /* one instance */
  size_t size;
  const pliant_descriptor *descriptor;
  void *data;                         /* the plugin's own */
  void (*destroy)(const struct pliant_plugin *);                                             /* [main & !active] */
  pliant_status (*set_number)(const struct pliant_plugin *, uint32_t index, double value);   /* [main & !active] numbers and choices */
  pliant_status (*set_text)(const struct pliant_plugin *, uint32_t index, const char *text); /* [main & !active] texts and paths */
  pliant_status (*set_table)(const struct pliant_plugin *, uint32_t index,
                             const double *values, size_t rows, size_t columns);             /* [main & !active] row-major */
  pliant_status (*activate)(const struct pliant_plugin *, const pliant_limits *);            /* [main & !active] */
  void (*deactivate)(const struct pliant_plugin *);                                          /* [main & active] */
  const void *(*extension)(const struct pliant_plugin *, const char *id);                    /* [any] NULL: not offered */
} pliant_plugin;

typedef struct pliant_library {
  size_t size;
  uint32_t abi_major, abi_minor;
  pliant_status (*init)(const pliant_host *, const char *folder);      /* [main] once, first; `folder` holds the library; or NULL */
  const pliant_descriptor *(*descriptor)(uint32_t index);              /* [any] NULL ends the list */
  const pliant_plugin *(*create)(const pliant_host *, const char *id); /* [main] NULL: refused */
} pliant_library;
/* A plugin defines: const pliant_library pliant_entry = { sizeof(pliant_library), PLIANT_ABI_MAJOR, ... };
 * The declaration below exports it; without it, a const of C++ has internal linkage. */
extern PLIANT_EXPORT const pliant_library pliant_entry;

/* ---- material: the force of a deformed body. The host owns all state and integrates the motion. ------------------- */
#define PLIANT_MATERIAL "pliant.material/1"

#define PLIANT_POINT       1u /* 1 corner;  measure: share of the volume (m^3) or, on a surface, of the area (m^2) */
#define PLIANT_LINK        2u /* 2 corners; measure: boundary weight, 1 inside the body */
#define PLIANT_TRIANGLE    3u /* 3 corners; measure: 1; material coordinates of each corner (m) */
#define PLIANT_HINGE       4u /* 4 corners: the edge a, b, then the vertex left of it and the one right of it; measure: 1 */
#define PLIANT_TETRAHEDRON 5u /* 4 corners, positive volume at rest; measure: the volume it stands for over its own, the share of
                                it that belongs to the body */

/* Families of links, by the direction they have in a grid of cubic cells. */
#define PLIANT_STRUCTURAL    1u /* along an edge of a cell */
#define PLIANT_SHEAR         2u /* along a face diagonal */
#define PLIANT_FLEXION       4u /* along two edges in a row */
#define PLIANT_BODY_DIAGONAL 8u /* along a body diagonal */

/* What a material offers for a kind of element; the host calls it for nothing else. */
#define PLIANT_HAS_MASS    1u
#define PLIANT_HAS_FORCES  2u /* energy, forces and stiffness */
#define PLIANT_HAS_DAMPING 4u /* forces depend on velocity */
#define PLIANT_HAS_HISTORY 8u /* `advance` is called after each accepted step */
#define PLIANT_IS_COUPLED 16u /* hinges and triangles: coupled bending; requires the extension pliant_coupled */
#define PLIANT_WANTS_NORMALS 32u /* triangles and hinges: an energy of vertex normals; requires the extension pliant_normals */
#define PLIANT_HAS_SINGLE 64u /* with HAS_FORCES: stiffness in single precision; requires the extension pliant_single */
#define PLIANT_INNER_TETRAHEDRON 128u /* tetrahedra: of the five of a cell only the inner one, which stands for the whole cell: its
                                         measure is three times the share of the cell that belongs to the body. A host that does
                                         not know the flag gives all five. */
#define PLIANT_CAN_FAIL 256u /* with HAS_HISTORY: elements may fail; requires the extension pliant_failure with `failed` not NULL, without
                                which the host refuses the material. A host that does not know the flag goes on with all elements. */

#define PLIANT_WANTS_DIRECTIONS 512u /* tetrahedra: fibre directions; requires the extension pliant_directions. A host that does not know the flag
                                      * calls `rest` of pliant_material: give the elements no fibres there. */

typedef struct pliant_element_request {  /* a kind of element the material works on */
  size_t size;
  uint32_t kind, families, flags; /* families: of links, else 0 */
  uint32_t rest_stride;    /* doubles of rest data per element, filled by `rest` */
  uint32_t history_stride; /* doubles of history per element; the host owns, copies and saves them; zero at the start, and again
                            * where the present shape is made the one at rest. An element that is cut gives it to its parts. */
} pliant_element_request;

typedef struct pliant_batch {  /* one call: elements [begin, end) of one kind, all of their nodes in [node_begin, node_end) */
  size_t size;
  uint32_t kind, corners;      /* corners per element, k */
  size_t begin, end, count;    /* count: elements of this kind in the body, m */
  size_t node_begin, node_end, nodes; /* nodes: nodes of the body, n */
  const uint32_t *elements;    /* (m x k) nodes of each element */
  const uint32_t *family;      /* (m), links only, or NULL */
  const double *measure;       /* (m) in the unit of the kind, see PLIANT_POINT and so on */
  const double *material;      /* (m x k x 2) m, triangles only, or NULL */
  const double *rest, *x, *v;  /* (n x 3) m, m, m/s: rest positions, positions, velocities */
  const double *rest_data;     /* (rest_stride x m), plane-major: value s of element e at [s * m + e] */
  const double *history;       /* (history_stride x m), plane-major */
  double time, dt;             /* s: time of the state, and the length of the step */
  /* Since 1.1; read `size` first, or use pliant_field. */
  size_t rest_stride, history_stride; /* planes behind rest_data and history */
  size_t field_count;          /* planes behind fields: as many as the material has parameters with PLIANT_PARAM_FIELD, or 0 */
  const double *fields;        /* (field_count x m), plane-major, or NULL: the factor of each of these parameters, in the order of their
                                * declaration, in each element; above 0. They do not change during a run. */
} pliant_batch;

/* Factors (m) of field parameter number `field`, counted among those with PLIANT_PARAM_FIELD; NULL: 1 everywhere. */
static inline const double *pliant_field(const pliant_batch *batch, size_t field) {
  if (batch->size < offsetof(pliant_batch, fields) + sizeof batch->fields || !batch->fields) return NULL;
  return field < batch->field_count ? batch->fields + field * batch->count : NULL;
}

/* Destination of stiffness: 3 x 3 row-major blocks of the host's symmetric matrix, upper triangle. Element e has
 * k (k + 1) / 2 slots, one per pair of corners a <= b in the order (0,0) (0,1) .. (0,k-1) (1,1) ..; see pliant_add_block. */
#define PLIANT_TRANSPOSED 0x80000000u /* set in a slot whose block is stored transposed */
typedef struct pliant_blocks {
  size_t size;
  double *values;          /* block s at [9 s] */
  const uint32_t *slots;   /* (m x k (k + 1) / 2) */
  size_t slot_begin, slot_end; /* the slots this call may write to */
} pliant_blocks;

/* Adds `block` at `slots[slot_index]`, where `slot_index` is e * k (k + 1) / 2 + the index of the pair of corners. */
static inline void pliant_add_block(const pliant_blocks *blocks, size_t slot_index, const double block[9]) {
  uint32_t slot = blocks->slots[slot_index];
  double *to = blocks->values + 9 * (size_t)(slot & ~PLIANT_TRANSPOSED);
  int i, j;
  if (slot & PLIANT_TRANSPOSED)
    for (i = 0; i < 3; i++) for (j = 0; j < 3; j++) to[3 * i + j] += block[3 * j + i];
  else
    for (i = 0; i < 9; i++) to[i] += block[i];
}

typedef struct pliant_material {
  size_t size;
  /* Fills in request number `index`, after the parameters are set; UNSUPPORTED ends the list. [main & active] */
  pliant_status (*elements)(const pliant_plugin *, uint32_t index, pliant_element_request *);
  /* Writes rest_data[s * m + e] for e in [begin, end), from `rest`, `measure` and `fields` only; called where rest_stride > 0.
   * [sim & active] */
  pliant_status (*rest)(const pliant_plugin *, const pliant_batch *, double *rest_data);
  /* mass[node] += lumped mass, kg. [sim & active] */
  pliant_status (*mass)(const pliant_plugin *, const pliant_batch *, double *mass);
  /* *energy += elastic energy, J. [sim & active] */
  pliant_status (*energy)(const pliant_plugin *, const pliant_batch *, double *energy);
  /* force[3 node + i] += -dE/dx - C v, N, with the velocities v of the batch. The host passes v = 0 where it takes C v from the matrix
   * of `tangent`, as in the first iteration of a step of backward Euler: so C may depend on x and not on v. [sim & active] */
  pliant_status (*forces)(const pliant_plugin *, const pliant_batch *, double *force);
  /* blocks += stiffness K + damping C; K = d2E/dx2 or a positive semi-definite approximation of it, N/m; C = -df/dv, N s/m;
   * `stiffness` and `damping` are factors. [sim & active] */
  pliant_status (*tangent)(const pliant_plugin *, const pliant_batch *, double stiffness, double damping, const pliant_blocks *);
  /* Reserved: set it to NULL. It was meant for products with the matrix that is not assembled; no host calls it, and the host
   * multiplies by the assembled matrix. A host that needs such products will ask for an extension. */
  pliant_status (*product)(const pliant_plugin *, const pliant_batch *, double stiffness, double damping, const double *p, double *out);
  /* Updates the history of [begin, end) after an accepted step, in the state the step ended in; NULL where no request has
   * HAS_HISTORY. `history` holds the values of the batch. At fixed positions an update must not add elastic energy. [sim & active] */
  pliant_status (*advance)(const pliant_plugin *, const pliant_batch *, double *history);
} pliant_material;

/* Optional: thin shells with coupled hinges (Hellan 1967, Herrmann 1967, Johnson 1973). The energy is s . m / 2 with
 * G m = s, where s_e (m) is the strain of hinge e, m_e (N) its bending moment per length of edge, and G (m/N) the sum of the
 * compliances of the triangles. The host assembles G, solves for m, and applies the forces -m ds/dx. */
#define PLIANT_COUPLED "pliant.coupled/1"
typedef struct pliant_coupled {
  size_t size;
  /* For hinges: writes plane 0, s_e, m, and planes 1 to 12, its gradient by corner and axis; layout as in `rest`. [sim & active] */
  pliant_status (*strain)(const pliant_plugin *, const pliant_batch *, double *planes);
  /* For triangles, from rest positions alone: writes six planes, m/N, the compliance between the sides 01, 12, 20 in the order
   * (0,0) (0,1) (0,2) (1,1) (1,2) (2,2). Positive definite. [sim & active] */
  pliant_status (*compliance)(const pliant_plugin *, const pliant_batch *, double *planes);
} pliant_coupled;

/* Optional: energies of triangles that depend on the sheet's unit normals at their corners, E(x, n). The host computes n(x),
 * the normalised sum of the area vectors of the triangles around each vertex, and applies the chain rule: the force is -dE/dx at
 * fixed n minus (dn/dx)^T dE/dn, the gradient of E(x, n(x)). The matrix approximates the energy by a spring against folding of
 * each hinge, with the stiffness `tilt` gives. */
#define PLIANT_NORMALS "pliant.normals/1"
typedef struct pliant_normals {
  size_t size;
  /* For triangles; normals (n x 3). *energy += E, J. [sim & active] */
  pliant_status (*energy)(const pliant_plugin *, const pliant_batch *, const double *normals, double *energy);
  /* For triangles; out (n x 6): out[6 node + i] += -dE/dx_i at fixed normals, N; out[6 node + 3 + i] += dE/dn_i, J.
   * [sim & active] */
  pliant_status (*forces)(const pliant_plugin *, const pliant_batch *, const double *normals, double *out);
  /* For triangles, from rest positions alone: writes three planes, N m: the second derivative of E by the angle at which a
   * corner's normal tilts across the side 01, 12, 20, the largest over the corners. Not negative. [sim & active] */
  pliant_status (*tilt)(const pliant_plugin *, const pliant_batch *, double *planes);
} pliant_normals;

/* Optional, for speed: stiffness in single precision, of elements that resist no translation (their blocks sum to zero over a
 * row). Only the off-diagonal blocks, a < b, are written; the host computes a diagonal block as minus the sum of the others of its
 * row. The host uses this where the rounding error is smaller than the tolerance of its solver, and `tangent` elsewhere. */
#define PLIANT_SINGLE "pliant.single/1"
typedef struct pliant_single_blocks {
  size_t size;
  float *values;           /* block s at [9 s] */
  const uint32_t *slots;   /* as in pliant_blocks, with the slots of diagonal blocks */
  size_t slot_begin, slot_end;
} pliant_single_blocks;

typedef struct pliant_single {
  size_t size;
  /* As `tangent`, without blocks (a, a), each entry to within single-precision rounding. [sim & active] */
  pliant_status (*tangent)(const pliant_plugin *, const pliant_batch *, double stiffness, double damping,
                           const pliant_single_blocks *);
} pliant_single;

/* Optional: failure. Elements of requests with CAN_FAIL, links that open or triangles that tear, have failed when the material says so. The
 * host then calls `energy`, `forces`, `tangent` and `advance` for the others only; masses and the history of what has failed stay. Not
 * together with IS_COUPLED or WANTS_NORMALS. */
#define PLIANT_FAILURE "pliant.failure/1"
typedef struct pliant_failure {
  size_t size;
  /* Not NULL. failed[e] = 1 for each element e of [begin, end) that has failed, else 0, from `history`, `rest_data`, `measure` and `fields`
   * alone; `failed` has `count` bytes, as the batch has elements, and no byte outside of [begin, end) may be written. The host asks after each
   * `advance`, where `rest` has been called again, and where it has put histories back, as for an undo. After an error it goes on with what was
   * said before. None has failed while its history is zero. [sim & active] */
  pliant_status (*failed)(const pliant_plugin *, const pliant_batch *, uint8_t *failed);
} pliant_failure;

/* Optional: fibre directions, for solids that are not the same in all directions. */
#define PLIANT_DIRECTIONS "pliant.directions/1"
typedef struct pliant_directions {
  size_t size;
  /* Not NULL. For requests with WANTS_DIRECTIONS the host calls it in place of `rest` of pliant_material; it writes the same rest_data.
   * directions (m x 3): of each element the unit vector along its fibres, in the axes of `rest`, the shape at rest; three zeros for an element
   * without fibres. Its sign has no meaning: the same line with the other sign gives the same energy. Where the host changes the shape at rest
   * it calls again, with directions that have followed that shape as lines of the material. [sim & active] */
  pliant_status (*rest)(const pliant_plugin *, const pliant_batch *, const double *directions, double *rest_data);
} pliant_directions;

/* Optional: the sources of the numbers behind a choice, printed by `pliant plugin info`. */
#define PLIANT_SOURCES "pliant.sources/1"
typedef struct pliant_sources {
  size_t size;
  /* Source number `index`, UNSUPPORTED past the last: it is the source of choice number `choice` of parameter number `param`.
   * `source` says who measured what, and when; `unknown` what was not measured or is doubtful, empty where nothing is. The texts
   * live as long as the library. [main & !active] */
  pliant_status (*source)(const pliant_plugin *, uint32_t index, uint32_t *param, uint32_t *choice, const char **source,
                          const char **unknown);
} pliant_sources;

/* ---- grid: the cells around a surface, and how the surface follows their nodes. ------------------------------------ */
#define PLIANT_GRID "pliant.grid/1"

#define PLIANT_CELL_EMPTY   0u
#define PLIANT_CELL_SURFACE 1u /* the surface passes through it: only such cells can be touched */
#define PLIANT_CELL_INSIDE  2u
#define PLIANT_NO_CELL UINT64_MAX
#define PLIANT_CELL_CORNERS 8u

typedef struct pliant_surface {  /* the surface `build` makes the cells for */
  size_t size;
  const double *points;          /* (n x 3) m */
  size_t point_count;
  const uint32_t *triangles;     /* (m x 3) */
  size_t triangle_count;
} pliant_surface;

typedef struct pliant_level {    /* one level of the octree; level 1 is the root, one cell */
  size_t size;
  uint32_t level, cells_per_axis;
  double edge;                   /* m, the length of a cell's edge */
  double origin[3];              /* m, the corner of cell 0 with the least coordinates */
  uint64_t surface_cells, inside_cells, nodes; /* nodes: corners of occupied cells */
} pliant_level;

typedef struct pliant_cell {     /* one cell of the octree */
  size_t size;
  uint64_t id, parent, children[8];  /* parent on the next coarser level, children on the next finer; PLIANT_NO_CELL: none */
  uint32_t index[3], state;      /* index along each axis; PLIANT_CELL_EMPTY and so on */
  double reference[3], centre[3], edge; /* m; reference: the corner with the least coordinates */
  size_t point_begin, point_end; /* the surface points inside it, as a range of `points` */
} pliant_cell;

typedef struct pliant_ball { double centre[3], radius; } pliant_ball; /* m; an infinite radius takes the whole body */

typedef struct pliant_region_request {
  size_t size;
  uint32_t level, families;      /* families of links wanted, 0: none */
  const pliant_ball *balls; size_t ball_count; /* occupied cells that touch a ball belong to the region */
  const uint64_t *cells; size_t cell_count; /* ids of further cells of the region */
} pliant_region_request;

/* The nodes, cells and links of a region, in buffers of the host. The plugin sets the counts to what is needed even where that
 * exceeds a capacity; it then returns TOO_SMALL, and the host calls again with larger buffers. */
typedef struct pliant_region {
  size_t size;
  size_t node_capacity, node_count;
  uint64_t *node_id;             /* (n), ascending: the same node has the same id in every region of a level */
  double *node_rest;             /* (n x 3) m, rest positions */
  double *node_measure;          /* (n) m^3, the volume of the body around the node */
  uint8_t *node_border;          /* (n) 1: an occupied cell outside the region has this node as a corner */
  size_t cell_capacity, cell_count;
  uint64_t *cell_id;             /* (c), ascending */
  uint32_t *cell_corners;        /* (c x 8) indices into the nodes above; corner i at bits (x, y, z) = (i & 1, i >> 1 & 1, i >> 2) */
  uint32_t *cell_points;         /* (c x 2) begin and end of its range of `points` */
  uint8_t *cell_state;           /* (c) PLIANT_CELL_SURFACE or PLIANT_CELL_INSIDE */
  size_t link_capacity, link_count;
  uint32_t *link_nodes;          /* (l x 2) indices into the nodes above, the lower one first */
  uint32_t *link_family;         /* (l) */
  double *link_measure;          /* (l) boundary weight, see PLIANT_LINK */
} pliant_region;

typedef struct pliant_grid {
  size_t size;
  /* Builds all levels up to `level`, the finest, and binds the surface's points to it. [worker & active] */
  pliant_status (*build)(const pliant_plugin *, const pliant_surface *, uint32_t level);
  /* Describes a level. [any & active] */
  pliant_status (*level)(const pliant_plugin *, uint32_t level, pliant_level *);
  /* Describes a cell; takes any id of the level: a cell that is not occupied is PLIANT_CELL_EMPTY. [any & active] */
  pliant_status (*cell)(const pliant_plugin *, uint32_t level, uint64_t id, pliant_cell *);
  /* The cell that contains a point (m), which is clamped to the grid first. `local` in [0, 1]^3. [any & active] */
  pliant_status (*locate)(const pliant_plugin *, uint32_t level, const double point[3], uint64_t *id, double local[3]);
  /* Indices of the surface points, sorted by cell of `level`; lives until the next `build`. [any & active] */
  pliant_status (*points)(const pliant_plugin *, uint32_t level, const uint32_t **points, size_t *count);
  /* Lists the nodes, cells and links of a region. [worker & active] */
  pliant_status (*region)(const pliant_plugin *, const pliant_region_request *, pliant_region *);
  /* For rest positions (count x 3, m): the cell of each and its interpolation weights over the cell's corners (count x 8, sum 1).
   * A position too far outside the body to belong to a cell gets PLIANT_NO_CELL and zeros; that is no error. [sim & active] */
  pliant_status (*weights)(const pliant_plugin *, uint32_t level, const double *positions, size_t count,
                           uint64_t *cells, double *weights);
  /* An embedding that is not linear in the corners, used in place of the weights; NULL or UNSUPPORTED where the weights are enough
   * (the host asks with count 0). `place` maps rest positions (count x 3, m) and the current corners of their cells
   * (count x 8 x 3, m) to current positions (count x 3, m). `pull_back` is the transpose of its derivative by the corners: from
   * loads on the points (count x 3, N) it adds the equivalent loads on the corners to corner_loads (count x 8 x 3, N).
   * [sim & active] */
  pliant_status (*place)(const pliant_plugin *, uint32_t level, const double *rest, size_t count, const double *corners,
                         double *positions);
  pliant_status (*pull_back)(const pliant_plugin *, uint32_t level, const double *rest, size_t count, const double *corners,
                             const double *loads, double *corner_loads);
} pliant_grid;

/* ---- contact law: the traction between a tool and a body where they touch. ------------------------------------------- */
#define PLIANT_CONTACT_LAW "pliant.contact-law/1"

#define PLIANT_ADHESIVE 1u /* the normal traction may be negative: the law attracts. Without it the host takes a negative one for an error */

/* The law acts at contact points, each of which stands for an area of the body's surface. At a point the unit normal leads from the tool to
 * the body; the tangent plane has two axes, which the host turns with the normal. Tractions are forces per area (Pa), on the body; the tool
 * gets the opposite. */
typedef struct pliant_contact_request {
  size_t size;
  uint32_t flags;          /* PLIANT_ADHESIVE */
  uint32_t history_stride; /* at most 64 doubles of history per contact point; the host owns them as long as the contact lasts; zero where it begins. An undo
                            * or a restored state of a body begins its contacts anew. */
  double reach;            /* m, the largest gap at which the law has a traction; 0 for a law of surfaces that touch */
} pliant_contact_request;

typedef struct pliant_contact_batch { /* one call: contact points [begin, end) */
  size_t size;
  size_t begin, end, count;  /* count: contact points, m */
  const double *gap;         /* (m) m, distance of the two surfaces along the normal; negative: they overlap */
  const double *gap_rate;    /* (m) m/s, rate of the gap; negative: they approach */
  const double *slip;        /* (2 x m) m, plane-major: path of the body along the tool since the contact began, along the two axes */
  const double *slip_rate;   /* (2 x m) m/s, plane-major: velocity of the body along the tool */
  const double *area;        /* (m) m^2, of the undeformed surface */
  const double *history;     /* (history_stride x m), plane-major */
  size_t history_stride;     /* planes behind history */
  double time, dt;           /* s: start of the step, and its length */
} pliant_contact_batch;

typedef struct pliant_traction {   /* results; the values of points outside of [begin, end) may not be written */
  size_t size;
  double *normal;                  /* (m) Pa; positive pushes the two apart; does not depend on slip */
  double *normal_by_gap;           /* (m) Pa/m, derivative of normal */
  double *normal_by_gap_rate;      /* (m) Pa s/m */
  double *tangential;              /* (2 x m) Pa, plane-major; friction is opposite to slip_rate */
  double *tangential_by_slip;      /* (4 x m) Pa/m, plane-major: d t_0/d s_0, d t_0/d s_1, d t_1/d s_0, d t_1/d s_1 */
  double *tangential_by_slip_rate; /* (4 x m) Pa s/m, as above. Derivatives of the tangential traction by the gap are not asked for: hosts
                                    * solve symmetric systems, and take friction at the pressure of the state they have linearised. */
} pliant_traction;

typedef struct pliant_contact_law {
  size_t size;
  /* Fills in the request, after the parameters are set. [main & active] */
  pliant_status (*request)(const pliant_plugin *, pliant_contact_request *);
  /* Writes tractions and derivatives of each point of [begin, end), from the values of that point alone. The host may ask for several
   * states of a step, such as that of a Newton iteration; `history` is always that at the start of the step. [sim & active] */
  pliant_status (*tractions)(const pliant_plugin *, const pliant_contact_batch *, const pliant_traction *);
  /* Updates the history of [begin, end) after an accepted step, in the state it ended in; NULL where history_stride is 0. `history` holds the
   * values of the batch. [sim & active] */
  pliant_status (*advance)(const pliant_plugin *, const pliant_contact_batch *, double *history);
} pliant_contact_law;

/* ---- device: reads the pose of a hand and renders force on it. ------------------------------------------------------ */
#define PLIANT_DEVICE "pliant.device/1"

#define PLIANT_POSE_VALID    1u /* position and orientation were measured for this sample */
#define PLIANT_POSE_VELOCITY 2u /* the velocity was measured too */

typedef struct pliant_device_info {
  size_t size;
  uint32_t effectors;            /* end effectors, held or worn: 1 for an arm, 2 for thumb and index */
  uint32_t buttons, driven_axes; /* driven axes: 3 force, 6 force and torque */
  uint32_t taxel_rows, taxel_columns; /* tactile array of each effector, 0: none; the pad faces -z of the effector's own axes,
                                       * rows go along its y, columns along x */
  double rate;                   /* Hz, nominal rate of `read` and `write` */
  double peak_force, continuous_force; /* N, for a moment and without end */
  double stiffness, damping;     /* N/m, N s/m: the largest it renders stably at `rate` */
  double resolution;             /* m, position quantum */
  double workspace[6];           /* m, least and greatest corner; equal where unbounded */
  double taxel_pitch, taxel_force; /* m between taxels, N the largest force of one */
  /* Since 1.1; a host of 1.0 passes a smaller struct: look at its `size` before filling it in. */
  double peak_torque;            /* N m, for a moment; without end the same part of it as the continuous force is of the peak force. 0: not
                                  * known, the host then scales torques as it scales forces, and renders none live */
} pliant_device_info;

typedef struct pliant_pose {     /* one sample of an effector */
  size_t size;
  uint64_t time_ns;              /* when it was measured */
  uint32_t flags, buttons;       /* PLIANT_POSE_...; button i is bit i */
  double position[3];            /* m, device axes: x right, y up, z towards the user */
  double orientation[4];         /* unit quaternion x y z w */
  double velocity[3];            /* m/s */
} pliant_pose;

typedef struct pliant_output {   /* what one effector is to render */
  size_t size;
  double force[3], torque[3];    /* N, N m, on the hand, device axes */
  const double *taxels;          /* (rows x columns) N, or NULL */
  uint64_t valid_until_ns;       /* after this time the device renders zero by itself */
} pliant_output;

typedef struct pliant_device {
  size_t size;
  /* Fills in the device's limits. [main & active] */
  pliant_status (*describe)(const pliant_plugin *, pliant_device_info *);
  /* Fills in the poses of all effectors at `time_ns`; hardware gives its newest sample instead. [servo & active] */
  pliant_status (*read)(const pliant_plugin *, uint64_t time_ns, pliant_pose *poses, size_t count);
  /* Sets what every effector is to render from `time_ns` on. [servo & active] */
  pliant_status (*write)(const pliant_plugin *, uint64_t time_ns, const pliant_output *outputs, size_t count);
  /* Renders zero at once. [any & active] */
  pliant_status (*stop)(const pliant_plugin *);
} pliant_device;

/* Optional: the force a device really renders, where it can tell. The conformance suite checks limits and expiry with it. */
#define PLIANT_RENDERED "pliant.rendered/1"
typedef struct pliant_rendered {
  size_t size;
  /* Fills in force and torque of each effector at `time_ns`; taxels stay NULL. [servo & active] */
  pliant_status (*rendered)(const pliant_plugin *, uint64_t time_ns, pliant_output *outputs, size_t count);
} pliant_rendered;

/* Optional: counters since the device was opened, such as datagrams lost on the way. */
#define PLIANT_COUNTERS "pliant.counters/1"
typedef struct pliant_counters {
  size_t size;
  /* Counter number `index`; UNSUPPORTED past the last. The name lives as long as the library. [any & active] */
  pliant_status (*counter)(const pliant_plugin *, uint32_t index, const char **name, uint64_t *value);
} pliant_counters;

/* Optional: checks what a device needs (driver, rights, cables) without opening it, for `pliant device doctor`. */
#define PLIANT_PROBE "pliant.probe/1"
/* Receives one finding about a requirement `what`: PLIANT_INFO it is met, PLIANT_WARNING the device works worse without it,
 * PLIANT_ERROR the device does not work without it. `found` is what was found, `remedy` what the user can do, empty where nothing
 * has to be done. The strings live for the call. */
typedef void (*pliant_say)(void *data, uint32_t severity, const char *what, const char *found, const char *remedy);
typedef struct pliant_probe {
  size_t size;
  /* Passes each finding to `say` together with `data`, with the parameters set so far; closes what it opened. [main & !active] */
  pliant_status (*probe)(const pliant_plugin *, void *data, pliant_say say);
} pliant_probe;

#ifdef __cplusplus
}
#endif
#endif
