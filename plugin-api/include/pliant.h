/* pliant.h: the plugin border, for C11 and C++17.
 *
 * A plugin is a shared library that exports one symbol, `pliant_entry`. SI units throughout; angles in rad.
 * Every struct starts with `size` (what its author compiled), so a minor release may append fields.
 *
 * Threads, in brackets after each function:
 *   [main]   one thread for the plugin's life; may allocate, read files and block briefly
 *   [worker] one call per instance at a time; may allocate and take seconds
 *   [sim]    inside a step; several calls of one instance at once, on disjoint nodes; must not allocate, lock or do I/O
 *   [servo]  one call at a time, 1-4 kHz, hard deadline; as [sim], and must not loop over a mesh
 *   [any]    all of them at once
 * `& active` / `& !active`: only between `activate` and `deactivate`, or only outside.
 *
 * Pointers are borrowed until the call returns unless a comment says longer. No pointer marked "or NULL" is null.
 */
#ifndef PLIANT_H
#define PLIANT_H
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

#define PLIANT_ABI_MAJOR 1u
#define PLIANT_ABI_MINOR 0u

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
#define PLIANT_PANICKED     -5  /* caught at the border; the host stops calling the instance */
#define PLIANT_TOO_SMALL    -6  /* a buffer; the counts say what is needed */
/* -1000 and below are the plugin's own. */

#define PLIANT_INFO    0u
#define PLIANT_WARNING 1u
#define PLIANT_ERROR   2u

/* ---- entry ------------------------------------------------------------------------------------------------------ */
typedef struct pliant_host {          /* outlives every instance it is handed to */
  size_t size;
  uint32_t abi_major, abi_minor;
  void *data;
  void (*report)(const struct pliant_host *, uint32_t severity, const char *text); /* [any] copies 255 bytes, never waits */
} pliant_host;

#define PLIANT_PARAM_NUMBER 1u /* a double in [min, max], in `unit` */
#define PLIANT_PARAM_CHOICE 2u /* one of `choices`, handed over as its index */
#define PLIANT_PARAM_TEXT   3u
#define PLIANT_PARAM_PATH   4u /* a file; relative ones are made absolute against the scene's folder */
#define PLIANT_PARAM_TABLE  5u /* rows x columns of finite doubles; `choices` names the columns, in order */

typedef struct pliant_param {
  uint32_t kind;
  const char *key;            /* kebab-case */
  const char *unit;           /* SI text: "Pa", "kg/m^3", "1" */
  const char *summary;        /* one line */
  double min, max, fallback;  /* `fallback` is the default; for a choice, its index */
  const char *choices;        /* "one|two|three", or NULL */
} pliant_param;

#define PLIANT_KIND_GRID     1u
#define PLIANT_KIND_MATERIAL 2u
#define PLIANT_KIND_DEVICE   3u
#define PLIANT_FLAG_REAL_TIME     1u /* [sim] and [servo] calls meet the rules above */
#define PLIANT_FLAG_DETERMINISTIC 2u /* same inputs, same bytes, on the same binary */

typedef struct pliant_descriptor {    /* lives as long as the library */
  size_t size;
  uint32_t kind, flags;
  const char *id, *name, *version, *summary;
  const pliant_param *params;
  size_t param_count, param_size;     /* param_size: sizeof(pliant_param) as compiled */
} pliant_descriptor;

typedef struct pliant_limits {
  size_t size;
  double dt;                          /* s, the longest step that will be asked for */
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
  pliant_status (*init)(const pliant_host *, const char *folder);                  /* [main] once, first */
  const pliant_descriptor *(*descriptor)(uint32_t index);                          /* [any] NULL ends the list */
  const pliant_plugin *(*create)(const pliant_host *, const char *id);             /* [main] NULL: refused */
} pliant_library;
/* A plugin defines: const pliant_library pliant_entry = { sizeof(pliant_library), PLIANT_ABI_MAJOR, ... };
 * It is exported from here, because a const of C++ would else be known to its own file only. */
extern PLIANT_EXPORT const pliant_library pliant_entry;

/* ---- material: what the force is. The host owns all state and says how it moves. --------------------------------- */
#define PLIANT_MATERIAL "pliant.material/1"

#define PLIANT_POINT       1u /* 1 corner;  measure: share of the volume (m^3) or, on a surface, of the area (m^2) */
#define PLIANT_LINK        2u /* 2 corners; measure: boundary weight, 1 inside the body */
#define PLIANT_TRIANGLE    3u /* 3 corners; measure: 1; material coordinates of each corner (m) */
#define PLIANT_HINGE       4u /* 4 corners: the edge a, b, then the vertex left of it and the one right of it; measure: 1 */
#define PLIANT_TETRAHEDRON 5u /* 4 corners, positive volume at rest; measure: the share of it that belongs to the body */

#define PLIANT_STRUCTURAL    1u /* families of links: along an edge of a cell, */
#define PLIANT_SHEAR         2u /* along a face diagonal, */
#define PLIANT_FLEXION       4u /* over two cells in a row, */
#define PLIANT_BODY_DIAGONAL 8u /* along a body diagonal */

#define PLIANT_HAS_MASS    1u
#define PLIANT_HAS_FORCES  2u /* energy, forces and stiffness */
#define PLIANT_HAS_DAMPING 4u
#define PLIANT_HAS_HISTORY 8u /* `advance` is called after each accepted step */
#define PLIANT_IS_COUPLED 16u /* hinges and triangles: bending by pliant_coupled, which must be there */
#define PLIANT_WANTS_NORMALS 32u /* triangles and hinges: an energy of vertex normals by pliant_normals, which must be there */
#define PLIANT_HAS_SINGLE 64u /* with HAS_FORCES: stiffness by pliant_single too, which must be there */

typedef struct pliant_element_request {
  size_t size;
  uint32_t kind, families, flags;
  uint32_t rest_stride;    /* doubles of rest data per element, filled by `rest` */
  uint32_t history_stride; /* doubles of history per element; the host owns, copies and saves them; zero at the start */
} pliant_element_request;

typedef struct pliant_batch {  /* one call: elements [begin, end) of one kind, all of their nodes in [node_begin, node_end) */
  size_t size;
  uint32_t kind, corners;      /* k */
  size_t begin, end, count;    /* count: all elements of this kind, m */
  size_t node_begin, node_end, nodes; /* nodes: all, n */
  const uint32_t *elements;    /* (m x k) */
  const uint32_t *family;      /* (m), links only, or NULL */
  const double *measure;       /* (m) */
  const double *material;      /* (m x k x 2) m, triangles only, or NULL */
  const double *rest, *x, *v;  /* (n x 3) m, m, m/s */
  const double *rest_data;     /* (rest_stride x m), plane-major: value s of element e at [s * m + e] */
  const double *history;       /* (history_stride x m), plane-major */
  double time, dt;             /* s */
} pliant_batch;

/* Where stiffness goes: 3 x 3 row-major blocks of the host's symmetric matrix, upper triangle. Element e has
 * k (k + 1) / 2 slots, one per pair a <= b in the order (0,0) (0,1) .. (0,k-1) (1,1) ..; see pliant_add_block. */
#define PLIANT_TRANSPOSED 0x80000000u
typedef struct pliant_blocks {
  size_t size;
  double *values;          /* block s at [9 s] */
  const uint32_t *slots;   /* (m x k (k + 1) / 2) */
  size_t slot_begin, slot_end; /* the slots this call may touch */
} pliant_blocks;

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
  /* The element kinds wanted, after the parameters are set; UNSUPPORTED ends the list. [main & active] */
  pliant_status (*elements)(const pliant_plugin *, uint32_t index, pliant_element_request *);
  /* rest_data[s * m + e] for e in [begin, end), from `rest` and `measure` only; where rest_stride > 0. [sim & active] */
  pliant_status (*rest)(const pliant_plugin *, const pliant_batch *, double *rest_data);
  /* mass[node] += kg. [sim & active] */
  pliant_status (*mass)(const pliant_plugin *, const pliant_batch *, double *mass);
  /* *energy += J. [sim & active] */
  pliant_status (*energy)(const pliant_plugin *, const pliant_batch *, double *energy);
  /* force[3 node + i] += -dE/dx - C v, N. [sim & active] */
  pliant_status (*forces)(const pliant_plugin *, const pliant_batch *, double *force);
  /* blocks += stiffness K + damping C; K = d2E/dx2 or a positive semi-definite stand-in. [sim & active] */
  pliant_status (*tangent)(const pliant_plugin *, const pliant_batch *, double stiffness, double damping, const pliant_blocks *);
  /* out += (stiffness K + damping C) p, both (n x 3), or NULL: the host multiplies by the assembled matrix. [sim & active] */
  pliant_status (*product)(const pliant_plugin *, const pliant_batch *, double stiffness, double damping, const double *p, double *out);
  /* history of [begin, end) after an accepted step, or NULL. [sim & active] */
  pliant_status (*advance)(const pliant_plugin *, const pliant_batch *, double *history);
} pliant_material;

/* Optional, for thin shells whose hinges act on each other (Hellan, Herrmann, Johnson): the energy is s . m / 2 with
 * G m = s, where s_e (m) is the strain of hinge e, m_e (N) its moment per length of edge, and G (m/N) the sum of the
 * compliances of the triangles. The host assembles G, solves, and applies -m ds/dx. */
#define PLIANT_COUPLED "pliant.coupled/1"
typedef struct pliant_coupled {
  size_t size;
  /* For hinges: plane 0 s_e, m; planes 1 to 12 its gradient, by corner and axis; as in `rest`. [sim & active] */
  pliant_status (*strain)(const pliant_plugin *, const pliant_batch *, double *planes);
  /* For triangles, from rest alone: six planes, m/N: compliance between the sides 01, 12, 20: (0,0) (0,1) (0,2) (1,1)
   * (1,2) (2,2). Positive definite. [sim & active] */
  pliant_status (*compliance)(const pliant_plugin *, const pliant_batch *, double *planes);
} pliant_coupled;

/* Optional, for energies of triangles that depend on the sheet's normals at their corners: E(x, n). The host finds the unit
 * normals n(x), the sums of the area vectors of the triangles around each vertex over their lengths, and pulls the slopes dE/dn
 * back through them: the force is -dE/dx at fixed n and what the normals add, so all of it is the slope of E(x, n(x)). In the matrix
 * a fold of every hinge stands for the energy, as stiff as `tilt` asks for. */
#define PLIANT_NORMALS "pliant.normals/1"
typedef struct pliant_normals {
  size_t size;
  /* For triangles; normals (n x 3). *energy += J. [sim & active] */
  pliant_status (*energy)(const pliant_plugin *, const pliant_batch *, const double *normals, double *energy);
  /* For triangles; out (n x 6): out[6 node + i] += -dE/dx_i at fixed normals, N; out[6 node + 3 + i] += dE/dn_i, J.
   * [sim & active] */
  pliant_status (*forces)(const pliant_plugin *, const pliant_batch *, const double *normals, double *out);
  /* For triangles, from rest alone: three planes, N m: d2E/dn2 of a corner's normal that tilts across the side 01, 12, 20, at
   * the stiffest corner. Not negative. [sim & active] */
  pliant_status (*tilt)(const pliant_plugin *, const pliant_batch *, double *planes);
} pliant_normals;

/* Optional, for speed: stiffness in single precision, of elements that resist no motion of all of their corners alike. Only
 * blocks of two corners are written, a < b; the host finds those of the diagonal, which are what the others of a row leave.
 * It asks for this where rounding matters less than what its solver leaves, and for `tangent` elsewhere. */
#define PLIANT_SINGLE "pliant.single/1"
typedef struct pliant_single_blocks {
  size_t size;
  float *values;           /* block s at [9 s] */
  const uint32_t *slots;   /* as in pliant_blocks, those of the diagonal too */
  size_t slot_begin, slot_end;
} pliant_single_blocks;

typedef struct pliant_single {
  size_t size;
  /* As `tangent`, without blocks (a, a), each number as exact as single precision has it. [sim & active] */
  pliant_status (*tangent)(const pliant_plugin *, const pliant_batch *, double stiffness, double damping,
                           const pliant_single_blocks *);
} pliant_single;

/* Optional: where the numbers behind a choice come from: `pliant plugin info`. */
#define PLIANT_SOURCES "pliant.sources/1"
typedef struct pliant_sources {
  size_t size;
  /* The source at a place, UNSUPPORTED past the last: that of choice `choice` of parameter `param`, both by their places,
   * and what it leaves open, empty where nothing. Texts live as long as the library. [main & !active] */
  pliant_status (*source)(const pliant_plugin *, uint32_t index, uint32_t *param, uint32_t *choice, const char **source,
                          const char **unknown);
} pliant_sources;

/* ---- grid: which nodes carry a surface, and how it follows them. -------------------------------------------------- */
#define PLIANT_GRID "pliant.grid/1"

#define PLIANT_CELL_EMPTY   0u
#define PLIANT_CELL_SURFACE 1u /* the surface passes through it: only such cells can be touched */
#define PLIANT_CELL_INSIDE  2u
#define PLIANT_NO_CELL UINT64_MAX
#define PLIANT_CELL_CORNERS 8u

typedef struct pliant_surface {  /* what `build` reads */
  size_t size;
  const double *points;          /* (n x 3) m */
  size_t point_count;
  const uint32_t *triangles;     /* (m x 3) */
  size_t triangle_count;
} pliant_surface;

typedef struct pliant_level {
  size_t size;
  uint32_t level, cells_per_axis;
  double edge;                   /* m, the length of a cell's edge */
  double origin[3];              /* m, the corner of cell 0 with the least coordinates */
  uint64_t surface_cells, inside_cells, nodes; /* nodes: corners of occupied cells */
} pliant_level;

typedef struct pliant_cell {     /* one node of the tree */
  size_t size;
  uint64_t id, parent, children[8];  /* PLIANT_NO_CELL where there is none */
  uint32_t index[3], state;
  double reference[3], centre[3], edge; /* m; reference: the corner with the least coordinates */
  size_t point_begin, point_end; /* the surface points inside it, as a range of `points` */
} pliant_cell;

typedef struct pliant_ball { double centre[3], radius; } pliant_ball; /* m; an infinite radius takes the whole body */

typedef struct pliant_region_request {
  size_t size;
  uint32_t level, families;      /* families of links wanted, 0: none */
  const pliant_ball *balls; size_t ball_count;
  const uint64_t *cells; size_t cell_count; /* cells to keep besides */
} pliant_region_request;

typedef struct pliant_region {   /* buffers of the host; counts say what was needed even where capacity was too small */
  size_t size;
  size_t node_capacity, node_count;
  uint64_t *node_id;             /* (n), rising: the same node has the same id in every region of a level */
  double *node_rest;             /* (n x 3) m */
  double *node_measure;          /* (n) m^3, the volume of the body around it */
  uint8_t *node_border;          /* (n) 1: an occupied cell outside the region touches it */
  size_t cell_capacity, cell_count;
  uint64_t *cell_id;             /* (c), rising */
  uint32_t *cell_corners;        /* (c x 8) places in the lists above; corner i at bits (x, y, z) = (i & 1, i >> 1 & 1, i >> 2) */
  uint32_t *cell_points;         /* (c x 2) its range of `points` */
  uint8_t *cell_state;           /* (c) */
  size_t link_capacity, link_count;
  uint32_t *link_nodes;          /* (l x 2), the first lower */
  uint32_t *link_family;         /* (l) */
  double *link_measure;          /* (l) */
} pliant_region;

typedef struct pliant_grid {
  size_t size;
  /* Builds all levels up to `level`, the finest, and binds the surface's points to it. [worker & active] */
  pliant_status (*build)(const pliant_plugin *, const pliant_surface *, uint32_t level);
  pliant_status (*level)(const pliant_plugin *, uint32_t level, pliant_level *);                             /* [any & active] */
  /* Any id within the level; one that is not occupied is PLIANT_CELL_EMPTY. [any & active] */
  pliant_status (*cell)(const pliant_plugin *, uint32_t level, uint64_t id, pliant_cell *);
  /* The cell of a point; clamped onto the grid. `local` in [0, 1]^3. [any & active] */
  pliant_status (*locate)(const pliant_plugin *, uint32_t level, const double point[3], uint64_t *id, double local[3]);
  /* Surface points sorted by cell of `level`; lives until the next `build`. [any & active] */
  pliant_status (*points)(const pliant_plugin *, uint32_t level, const uint32_t **points, size_t *count);
  /* [worker & active] */
  pliant_status (*region)(const pliant_plugin *, const pliant_region_request *, pliant_region *);
  /* Cells and weights (count x 8, sum 1) of rest places over the corners of their cells. A place too far outside the body
   * to belong to a cell gets PLIANT_NO_CELL and zeros, and is no error. [sim & active] */
  pliant_status (*weights)(const pliant_plugin *, uint32_t level, const double *places /* (count x 3) m */, size_t count,
                           uint64_t *cells, double *weights);
  /* For an embedding that is not linear, else NULL or UNSUPPORTED (asked with count 0): places (count x 3) from rest places and the corners of their
   * cells (count x 8 x 3), and corner loads (count x 8 x 3) += transpose of that map's derivative times loads. [sim & active] */
  pliant_status (*place)(const pliant_plugin *, uint32_t level, const double *rest, size_t count, const double *corners, double *places);
  pliant_status (*pull_back)(const pliant_plugin *, uint32_t level, const double *rest, size_t count, const double *corners,
                             const double *loads, double *corner_loads);
} pliant_grid;

/* ---- device: where the hand is, and what to give it. --------------------------------------------------------------- */
#define PLIANT_DEVICE "pliant.device/1"

#define PLIANT_POSE_VALID    1u /* position and orientation were sensed for this sample */
#define PLIANT_POSE_VELOCITY 2u /* so was the velocity */

typedef struct pliant_device_info {
  size_t size;
  uint32_t effectors;            /* places a hand can hold or wear: 1 for an arm, 2 for thumb and index */
  uint32_t buttons, driven_axes; /* driven axes: 3 force, 6 force and torque */
  uint32_t taxel_rows, taxel_columns; /* per effector, 0: none; the pad faces -z of the effector's own axes, rows go along its
                                       * y, columns along x */
  double rate;                   /* Hz, nominal */
  double peak_force, continuous_force; /* N */
  double stiffness, damping;     /* N/m, N s/m: the most it renders stably at `rate` */
  double resolution;             /* m, position quantum */
  double workspace[6];           /* m, least and greatest corner */
  double taxel_pitch, taxel_force; /* m, N */
} pliant_device_info;

typedef struct pliant_pose {
  size_t size;
  uint64_t time_ns;
  uint32_t flags, buttons;       /* button i is bit i */
  double position[3];            /* m, device axes: x right, y up, z towards the user */
  double orientation[4];         /* unit quaternion x y z w */
  double velocity[3];            /* m/s */
} pliant_pose;

typedef struct pliant_output {   /* what one effector is to render */
  size_t size;
  double force[3], torque[3];    /* N, N m, on the hand */
  const double *taxels;          /* (rows x columns) N, or NULL */
  uint64_t valid_until_ns;       /* past this the device falls to zero by itself */
} pliant_output;

typedef struct pliant_device {
  size_t size;
  pliant_status (*describe)(const pliant_plugin *, pliant_device_info *);                              /* [main & active] */
  /* The poses of all effectors at `time_ns`; a real device gives its newest. [servo & active] */
  pliant_status (*read)(const pliant_plugin *, uint64_t time_ns, pliant_pose *poses, size_t count);
  pliant_status (*write)(const pliant_plugin *, uint64_t time_ns, const pliant_output *outputs, size_t count); /* [servo & active] */
  pliant_status (*stop)(const pliant_plugin *);                                                        /* [any & active] zero at once */
} pliant_device;

/* Optional, for devices that know: what they really render. The conformance suite holds limits and expiry against it. */
#define PLIANT_RENDERED "pliant.rendered/1"
typedef struct pliant_rendered {
  size_t size;
  /* Force and torque of each effector at `time_ns`; taxels stay NULL. [servo & active] */
  pliant_status (*rendered)(const pliant_plugin *, uint64_t time_ns, pliant_output *outputs, size_t count);
} pliant_rendered;

/* Optional: what a device has counted since it was opened, such as datagrams lost on the way. */
#define PLIANT_COUNTERS "pliant.counters/1"
typedef struct pliant_counters {
  size_t size;
  /* The counter at a place; UNSUPPORTED past the last. The name lives as long as the library. [any & active] */
  pliant_status (*counter)(const pliant_plugin *, uint32_t index, const char **name, uint64_t *value);
} pliant_counters;

/* Optional: what a device needs, whether it is there, and how to get it: `pliant device doctor`. */
#define PLIANT_PROBE "pliant.probe/1"
/* One finding: PLIANT_INFO it is there, PLIANT_WARNING it works worse without, PLIANT_ERROR it does not work without. The
 * strings live for the call; `remedy` is empty where nothing is to be done. */
typedef void (*pliant_say)(void *data, uint32_t severity, const char *what, const char *found, const char *remedy);
typedef struct pliant_probe {
  size_t size;
  /* Says each finding with the parameters set so far; holds on to nothing it opened. [main & !active] */
  pliant_status (*probe)(const pliant_plugin *, void *data, pliant_say say);
} pliant_probe;

#ifdef __cplusplus
}
#endif
#endif
