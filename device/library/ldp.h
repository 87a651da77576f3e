/* Layered depth panoramas (.ldp files) in C: open, describe, read planes, render views, write.
 *
 * World: right-handed, lengths in the capture's own unit (metres where the cameras were estimated), angles radians.
 * The cameras lay on a circle, the arc. A panorama is a grid of rays over it, `width` columns clockwise seen from above
 * by `height` rows from top to bottom: column x looks along theta(x) = theta_left - (x + 0.5) theta_pitch, row y has
 * v(y) = v_top - (y + 0.5) v_pitch. With C, n, r the arc's centre, axis and radius and u(theta) the outward horizontal
 * unit vector, the point of a pixel at depth d is
 *   LDP_RAYS_PUSHBROOM:  C + (r + d) u(theta) + d v n
 *   LDP_RAYS_CENTRAL:    C +      d  u(theta) + d v n.
 * It has up to 8 layers on that grid, front to back; the first is dense, later ones are present only where some
 * photograph sees behind those before.
 *
 * Planes and pictures: rows from top to bottom, packed or with `row_pixels` pixels from one row to the next.
 * Images: pixel centres at .5.
 *
 * Threads: a panorama may be used by any number of threads at a time, but for ldp_close; a writer by one at a time.
 * Errors: every call that can fail gives an ldp_status and, if `error` is no null pointer, says in it what was
 * attempted, on what, and what was found. Outputs are untouched then, but for buffers of planes and views. Nothing is
 * global, nothing is printed. Versions: structs with `struct_bytes` may grow at their end; set it by LDP_INIT.
 * Functions and values stay. */
#ifndef LDP_H
#define LDP_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A struct of this library, its size told and all else zero: ldp_limits limits = LDP_INIT(ldp_limits); */
#ifdef __cplusplus
}
template <typename Struct>
inline Struct ldp_initialised() {
  Struct made = Struct();
  made.struct_bytes = static_cast<uint32_t>(sizeof(Struct));
  return made;
}
extern "C" {
#define LDP_INIT(type) ldp_initialised<type>()
#else
#define LDP_INIT(type) ((type){.struct_bytes = (uint32_t)sizeof(type)})
#endif

typedef enum ldp_status {
  LDP_OK = 0,
  LDP_BAD_ARGUMENT =
      1, /* something that cannot be meant: a null pointer, a layer that is not there, a view of size 0 */
  LDP_NOT_READABLE = 2,  /* the system refused: no such file, no permission, no room */
  LDP_DAMAGED = 3,       /* no .ldp file, or one that is damaged or of a newer version */
  LDP_BEYOND_LIMITS = 4, /* sound, but more than the limits given allow */
  LDP_OUT_OF_MEMORY = 5,
  LDP_STOPPED = 6, /* by ldp_stop_request */
  LDP_INTERNAL = 7 /* a fault of this library: please report it */
} ldp_status;

typedef struct ldp_error {
  int32_t status;    /* ldp_status */
  char message[508]; /* one line of UTF-8, ended by a zero; cut off where it is longer */
} ldp_error;

typedef struct ldp_panorama ldp_panorama; /* an open file; immutable */
typedef struct ldp_writer ldp_writer;     /* a file in the making */
typedef struct ldp_stop ldp_stop;         /* asks work under way to end */

const char* ldp_version(void); /* of this library, e.g. "0.1.0" */

/* ---- Stopping work under way, from another thread ---- */
ldp_stop* ldp_stop_new(void); /* null pointer: out of memory */
void ldp_stop_request(ldp_stop* stop);
void ldp_stop_free(ldp_stop* stop); /* when no call uses it any more */

/* ---- Opening ---- */
typedef struct ldp_limits {
  uint32_t struct_bytes;
  uint32_t reserved;
  uint64_t pixels;       /* of the grid, at most; 0 = what the format allows, 2^28 */
  uint64_t memory_bytes; /* that decoding and views may take, at most; 0 = no limit. A kilobyte may declare gigabytes */
} ldp_limits;

/* limits: may be a null pointer. Checks table, checksums of what it reads and every bound; decodes no layer. The bytes
 * are copied. A file is read as a whole, and may be replaced meanwhile. */
ldp_status ldp_open_file(const char* path, const ldp_limits* limits, ldp_panorama** panorama, ldp_error* error);
ldp_status ldp_open_memory(const void* bytes, size_t count, const ldp_limits* limits, ldp_panorama** panorama,
                           ldp_error* error);
void ldp_close(ldp_panorama* panorama); /* null pointer: nothing happens */

/* ---- Describing ---- */
enum { LDP_RAYS_PUSHBROOM = 0, LDP_RAYS_CENTRAL = 1 };

typedef struct ldp_description {
  uint32_t struct_bytes;
  int32_t format_version; /* of the file; a writer chooses */
  uint64_t file_bytes;
  int32_t width, height;                                      /* of the grid, pixels */
  int32_t layers, cameras, quality_figures, metadata_entries; /* how many; a writer counts */
  int32_t rays;                                               /* LDP_RAYS_... */
  int32_t wraps;                                              /* 1: column `width` is column 0 again */
  int32_t arc_closed;                                         /* 1: the sweep came back to its start */
  int32_t reserved;
  double theta_left, theta_pitch, v_top, v_pitch;
  double far_inverse_depth, near_inverse_depth; /* disparity 0 and LDP_MOST_DISPARITY; far may be 0 = at infinity */
  double arc_centre[3];
  double world_from_arc[9]; /* by rows; columns u(0), u(pi/2), n */
  double arc_radius;
  double theta_begin, theta_end;                 /* of the hand's path */
  double inner_radius, outer_radius, max_height; /* views hold there: distance from the axis, height over the plane */
} ldp_description;

typedef struct ldp_layer_description {
  uint32_t struct_bytes;
  int32_t block_px; /* side of the blocks with a depth range of their own; 0: one range */
  int32_t has_alpha;
  int32_t reserved;
  uint64_t present_pixels;
} ldp_layer_description;

/* A pinhole camera with distortion, as transforms.json has it. */
typedef struct ldp_camera {
  uint32_t struct_bytes;
  int32_t width, height; /* pixels, 1 .. 16384 */
  int32_t reserved;
  double fl_x, fl_y, cx, cy;    /* pixels */
  double k1, k2, p1, p2;        /* Brown-Conrady */
  double world_from_camera[16]; /* 4x4 by rows; camera axes x right, y up, z back; a rotation and a position */
} ldp_camera;

ldp_status ldp_describe(const ldp_panorama* panorama, ldp_description* description, ldp_error* error);
ldp_status ldp_describe_layer(const ldp_panorama* panorama, int layer, ldp_layer_description* description,
                              ldp_error* error);
/* The photographs' cameras. *name (the photo's file name) lasts until ldp_close; either pointer may be null. */
ldp_status ldp_get_camera(const ldp_panorama* panorama, int index, ldp_camera* camera, const char** name,
                          ldp_error* error);
/* Figures such as "expected_view_psnr_db", and texts such as "captured_utc", in the order of their names. */
ldp_status ldp_get_quality(const ldp_panorama* panorama, int index, const char** name, double* value, ldp_error* error);
ldp_status ldp_get_metadata(const ldp_panorama* panorama, int index, const char** name, const char** value,
                            ldp_error* error);
/* A small JPEG file; *count is 0 where there is none. Lasts until ldp_close. */
ldp_status ldp_get_thumbnail(const ldp_panorama* panorama, const uint8_t** bytes, size_t* count, ldp_error* error);
/* Every checksum and bound of the whole file, layers decoded. */
ldp_status ldp_verify(const ldp_panorama* panorama, ldp_stop* stop, ldp_error* error);

/* ---- Planes of a layer ---- */
#define LDP_MOST_DISPARITY 3825 /* inverse depth = far + (near - far) disparity / 3825 */
#define LDP_NO_DISPARITY 65535  /* nothing is there */

/* Columns begin <= x < end of all rows, (end - begin) by height. Null pointers: not wanted. */
typedef struct ldp_planes {
  uint32_t struct_bytes;
  int32_t begin, end;  /* both 0: all columns */
  int32_t threads;     /* 0 = 1 */
  int64_t row_pixels;  /* 0 = end - begin */
  float* depth;        /* d, capture's unit; 0 = nothing is there, infinity = at infinity */
  uint16_t* disparity; /* as stored: 0 .. LDP_MOST_DISPARITY or LDP_NO_DISPARITY */
  uint8_t* coverage;   /* 1 = present */
  uint8_t* alpha;      /* 0 where absent, else the silhouette's opacity, 255 without one */
  uint8_t* rgb;        /* 3 bytes a pixel, sRGB; 0 0 0 where absent */
  ldp_stop* stop;
} ldp_planes;

/* Layer 0 is the front one. Only the part asked for is decoded, and colour only where rgb is. */
ldp_status ldp_read_planes(const ldp_panorama* panorama, int layer, const ldp_planes* planes, ldp_error* error);

/* ---- Views ---- */
enum { LDP_FILL_NONE = 0, LDP_FILL_BACKGROUND = 1 };

typedef struct ldp_view {
  uint32_t struct_bytes;
  int32_t layers;     /* drawn at most; 0 = all */
  int32_t fill;       /* of holes: LDP_FILL_NONE, or LDP_FILL_BACKGROUND, which continues what lies behind */
  int32_t threads;    /* 0 = 1; the view is the same at any number */
  int64_t row_pixels; /* 0 = the camera's width */
  uint8_t* rgb;       /* 3 bytes a pixel, sRGB; may be null, as may the others */
  uint8_t* alpha;     /* 0 = hole */
  float* depth;       /* along the camera's forward axis; 0 = nothing, infinity = at infinity */
  ldp_stop* stop;
} ldp_view;

/* The first view decodes all layers; it and later ones make a mesh of what they see of them, once. ldp_prepare does all
 * of that before. The pixels are those of `ldp render`. */
ldp_status ldp_prepare(ldp_panorama* panorama, int threads, ldp_stop* stop, ldp_error* error);
ldp_status ldp_render(ldp_panorama* panorama, const ldp_camera* camera, const ldp_view* view, ldp_error* error);

/* All cameras of a path ("sway", "walk" or "dolly"), `frames` of them, 1 .. 100000. Of cameras[0] struct_bytes, width
 * and height are taken; the rest, and the others, are given. fov_rad: horizontal; 0 = that of the photos, or less. They
 * are framed inside what the panorama shows, which takes some small views, like those of `ldp render --path`. */
ldp_status ldp_cameras_on_path(ldp_panorama* panorama, const char* path, int frames, double fov_rad,
                               ldp_camera* cameras, ldp_error* error);

/* ---- Writing ---- */
/* A file that is empty yet. Of description: grid, arc and limits. */
ldp_status ldp_writer_new(const ldp_description* description, ldp_writer** writer, ldp_error* error);
/* One that holds all that a panorama does, depth exactly, colour as it was decoded. */
ldp_status ldp_writer_from(const ldp_panorama* panorama, ldp_writer** writer, ldp_error* error);
void ldp_writer_free(ldp_writer* writer);
/* The next layer behind those there are, copied. Taken of planes: rgb, and disparity (preferred) or depth; alpha where
 * it is no null pointer. Depth becomes 4-bit codes in blocks of block_px pixels, 0 .. 256. */
ldp_status ldp_writer_add_layer(ldp_writer* writer, const ldp_planes* planes, int block_px, ldp_error* error);
ldp_status ldp_writer_add_camera(ldp_writer* writer, const char* name, const ldp_camera* camera, ldp_error* error);
ldp_status ldp_writer_set_quality(ldp_writer* writer, const char* name, double value, ldp_error* error);
ldp_status ldp_writer_set_metadata(ldp_writer* writer, const char* name, const char* value, ldp_error* error);
/* colour_quality: 1 .. 100, 101 = lossless, 0 = 90. The file appears whole or not at all. */
ldp_status ldp_writer_save(const ldp_writer* writer, const char* path, int colour_quality, ldp_error* error);
/* *bytes: to be given to ldp_free. */
ldp_status ldp_writer_encode(const ldp_writer* writer, int colour_quality, void** bytes, size_t* count,
                             ldp_error* error);
void ldp_free(void* bytes);

#ifdef __cplusplus
}
#endif
#endif
