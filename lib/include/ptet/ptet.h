/* The C interface of the run-time library: open a .ptet file, say what is asked of it, take the mesh out.
 *
 *   ptet_dataset --ptet_dataset_extract(ptet_request)--> ptet_extraction: arrays that are read in place
 *   ptet_session --ptet_session_update(ptet_request)--> the same mesh, by what differs from the last
 *
 * It is meant to be called from any language: opaque handles, fixed-width integers, structs of plain members without
 * bit fields, callbacks that get a pointer of their user's; nothing here must be expanded by a preprocessor.
 *
 * Handles  Each kind has its own function to free it, which does nothing for NULL. Handles do not depend on one
 *          another: an extraction outlives its dataset. Pointers that a function returns belong to the handle they come
 *          from and are valid until it is freed (for a request: there are none).
 * Errors   What can fail returns a ptet_status, PTET_OK or what went wrong, and takes as its last argument where to put
 *          an error object that says more; that argument may be NULL. On success NULL is put there, on failure a new
 *          object, to be freed by ptet_error_free; what was there before is not looked at. Where a handle is made it is
 *          NULL after a failure. No exception leaves a function, and a NULL handle is an error, not a crash; functions
 *          that cannot fail answer 0, NULL, "" or NaN for a NULL handle.
 * Structs  The first member of a struct is its size in bytes as the caller knows it; it must be set before every call.
 *          Members that a later version adds come at the end: a library that does not know them sets them to 0, and
 *          one that knows more than the caller leaves them out.
 * Text     UTF-8 as the file has it, ended by a NUL.
 * Threads  Any number of threads may use one ptet_dataset at a time. Any other handle: any number of threads may read
 *          it (functions that take it const), or one may change it. Callbacks must not call into the handles that the
 *          running call uses. Progress is reported to the thread that called the library.
 *
 * Numbers of vertices and tets in arrays are 0-based. PTET.md and the C++ headers beside this file say more about the
 * meaning of errors. */
#ifndef PTET_PTET_H
#define PTET_PTET_H

/* NOLINTBEGIN: the names and idioms of C */
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Version ---- */

/* Raised when something that was there changes its meaning or goes; additions do not raise it. */
enum { PTET_ABI_VERSION = 1 };

/* PTET_ABI_VERSION of the library that is linked: it must be the one that the caller was written for. */
uint32_t ptet_abi_version(void);
/* "major.minor.patch" of the library that is linked. */
const char* ptet_version(void);

/* ---- Errors ---- */

typedef int32_t ptet_status;
enum {
  PTET_OK = 0,
  PTET_INTERNAL_ERROR = 1, /* a fault of the library, or an exception of a callback */
  PTET_BAD_ARGUMENT = 2,   /* a NULL where none may be, a number out of range, a field that is not there */
  PTET_BAD_INPUT = 3,      /* a mesh or field that cannot be handled */
  PTET_CORRUPT_FILE = 4,   /* a .ptet file that breaks its specification */
  PTET_LIMIT = 5,          /* a size limit would be passed */
  PTET_IO_ERROR = 6,       /* the operating system, or the user's read function, refused to read or write */
  PTET_OUT_OF_MEMORY = 7,
  PTET_CANCELLED = 130 /* the progress callback asked to stop */
};
/* "corrupt file" and so on; "unknown" for any other number. */
const char* ptet_status_name(ptet_status status);

typedef struct ptet_error ptet_error;
/* PTET_OK for NULL. */
ptet_status ptet_error_status(const ptet_error* error);
/* One sentence that a user can act on; "" for NULL. */
const char* ptet_error_message(const ptet_error* error);
/* The byte of the file that the error is about; UINT64_MAX (all bits set) when it is about none. */
uint64_t ptet_error_offset(const ptet_error* error);
void ptet_error_free(ptet_error* error);

/* ---- Callbacks ---- */

/* Told how far a call has come, by the thread that makes it: as a rule some hundred times a second, of small meshes
 * more often. `total` is 0 while it is unknown. `stage` is valid during the callback only. Any answer but 0 cancels:
 * the running call ends with PTET_CANCELLED and leaves nothing behind.
 */
typedef int32_t (*ptet_progress_callback)(const char* stage, uint64_t done, uint64_t total, void* user);

/* Fills `into` with `size` bytes from `offset`, which lie inside the file. Any answer but 0 means that they cannot be
 * had: opening ends with PTET_IO_ERROR, whose message names the number; later the answers are coarser that need them,
 * and say so (ptet_extraction_get_failure). Called from any thread, one call at a time. What may hang, as a connection
 * does, has to have a time limit: freeing the last of a dataset waits for a read that is under way. */
typedef int32_t (*ptet_read_callback)(void* user, uint64_t offset, uint64_t size, void* into);
typedef void (*ptet_release_callback)(void* user);

/* ---- Datasets ---- */

typedef int32_t ptet_scalar_type;
enum {
  PTET_INT8 = 0,
  PTET_UINT8 = 1,
  PTET_INT16 = 2,
  PTET_UINT16 = 3,
  PTET_INT32 = 4,
  PTET_UINT32 = 5,
  PTET_INT64 = 6,
  PTET_UINT64 = 7,
  PTET_FLOAT32 = 8,
  PTET_FLOAT64 = 9
};

/* A user's own source of bytes: a part of a larger file, a range request to a server, an object store. */
typedef struct ptet_source {
  uint64_t struct_size;
  uint64_t size; /* of the file, bytes; it must not change */
  void* user;    /* handed to the callbacks */
  ptet_read_callback read;
  /* NULL, or called once when nothing will be read any more; when opening fails, then, but not after a
   * PTET_BAD_ARGUMENT. */
  ptet_release_callback release;
} ptet_source;

/* How a file is opened. Members that are 0 mean what is said; NULL instead of the struct means all of them 0. */
typedef struct ptet_open_options {
  uint64_t struct_size;
  uint64_t memory_limit; /* bytes that decoded blocks may take; 0: what max_bytes leaves */
  uint64_t max_gap;      /* blocks so many bytes or less apart are read by one request, with what is between them; for a
                            server some 500,000 are good */
  uint64_t max_bytes;    /* memory for all that the dataset holds; 0: 2^35 */
  uint64_t max_vertices; /* of the original; 0: 2^30 */
  uint64_t max_tets;     /* of the original; 0: 2^32 */
  int32_t background;    /* not 0: a thread of the dataset reads, extractions answer with what is there */
  uint32_t reserved;     /* 0 */
} ptet_open_options;

typedef struct ptet_dataset_info {
  uint64_t struct_size;
  uint64_t vertices; /* of the original */
  uint64_t tets;
  uint64_t base_vertices; /* that tets of the coarsest mesh use */
  uint64_t base_tets;
  uint64_t records; /* vertex splits, of which every other mesh is made */
  uint64_t blocks;
  uint64_t file_bytes;
  uint32_t fields; /* point arrays, see ptet_dataset_get_field */
  ptet_scalar_type position_type;
  double box_min[3]; /* of the domain, which vertices in no tet are not part of, mesh units */
  double box_max[3];
  double diagonal;           /* of that box: what relative domain errors refer to */
  double max_domain_error;   /* the largest of any level, mesh units */
  int32_t has_input_order;   /* 1: the file keeps the order of its input (ptet_request_set_input_order) */
  int32_t errors_are_bounds; /* 0: errors are what the build has seen, and the true ones may be larger */
  double base_covered;       /* of the coarsest mesh, as ptet_extraction_covered */
  int32_t overlaps_itself;   /* 1: some of the original's tets were found to lie in one another, and errors there are
                              * those of each part by itself */
  uint32_t reserved;         /* 0 */
  uint64_t memory_for_all;   /* max_bytes with which all blocks fit into memory: an estimate, rather high */
} ptet_dataset_info;

typedef struct ptet_field_info {
  uint64_t struct_size;
  const char* name; /* valid until the dataset is freed */
  ptet_scalar_type type;
  uint32_t components;
  int32_t governing; /* 1: its errors are in the file; 0: it is carried along */
  uint32_t reserved; /* 0 */
  double range; /* largest minus least value (vectors: diagonal of the box of values): what relative errors refer to;
                 * 0 when it does not govern: the file does not tell */
  double max_error; /* the largest of any level, units of the field; NaN when it does not govern */
  double max_rms;   /* the root mean square error of the coarsest mesh; NaN when it was not measured */
} ptet_field_info;

typedef struct ptet_dataset ptet_dataset;
typedef struct ptet_request ptet_request;
typedef struct ptet_extraction ptet_extraction;

/* Reads header, table and base mesh; the rest is read as extractions need it.
 * Errors: PTET_BAD_ARGUMENT, PTET_IO_ERROR, PTET_CORRUPT_FILE (with an offset), PTET_LIMIT. */
ptet_status ptet_dataset_open(const char* path, const ptet_open_options* options, ptet_dataset** dataset,
                              ptet_error** error);
/* The same over `size` bytes in memory, which are copied. */
ptet_status ptet_dataset_open_memory(const void* bytes, uint64_t size, const ptet_open_options* options,
                                     ptet_dataset** dataset, ptet_error** error);
/* The same over a user's source; the struct is copied, its callbacks are used as long as the dataset lives. */
ptet_status ptet_dataset_open_source(const ptet_source* source, const ptet_open_options* options,
                                     ptet_dataset** dataset, ptet_error** error);
void ptet_dataset_free(ptet_dataset* dataset);
/* Bytes read from the file so far, opening included; 0 for NULL. */
uint64_t ptet_dataset_bytes_read(const ptet_dataset* dataset);

ptet_status ptet_dataset_get_info(const ptet_dataset* dataset, ptet_dataset_info* info, ptet_error** error);
/* `field`: 0 to ptet_dataset_info.fields - 1. */
ptet_status ptet_dataset_get_field(const ptet_dataset* dataset, uint32_t field, ptet_field_info* info,
                                   ptet_error** error);
/* The number of the field of that name; -1 when there is none. */
int32_t ptet_dataset_find_field(const ptet_dataset* dataset, const char* name);
/* Where the file comes from, as JSON: version of the tool, options of the build, name and hash of its input. */
const char* ptet_dataset_provenance(const ptet_dataset* dataset);

/* With ptet_open_options.background: waits until the blocks that extractions asked for are loaded, or found not to be
 * had; without, returns at once. With a budget, which blocks it takes is found out one after the other: where the next
 * extraction is still PTET_LIMITED_BY_LOADING, wait and ask again. `progress` may be NULL. */
ptet_status ptet_dataset_wait_until_loaded(const ptet_dataset* dataset, ptet_progress_callback progress, void* user,
                                           ptet_error** error);

/* ---- Requests ---- */

/* A request is made empty, and filled by functions: each adds a condition, in any order. An empty request, as NULL
 * instead of one, asks for the original mesh. Whether a field is there and a number makes sense is found by
 * ptet_dataset_extract, which knows the file.
 *
 * An error is a value with a flag `relative`: 0, in the units of the field (the mesh, for domain errors); else, as a
 * fraction of the field's range (the diagonal): 0.01 is 1%. */
ptet_request* ptet_request_new(void); /* NULL when memory is out */
void ptet_request_free(ptet_request* request);
/* Empties it. No condition is taken back by itself: who changes one clears the request and fills it anew. */
ptet_status ptet_request_clear(ptet_request* request, ptet_error** error);

/* The error of `field` may be at most this; "" or NULL: of every governing field. */
ptet_status ptet_request_add_field_error(ptet_request* request, const char* field, double value, int32_t relative,
                                         ptet_error** error);
/* No point of the boundary or the original's may be further from the other than this. */
ptet_status ptet_request_set_domain_error(ptet_request* request, double value, int32_t relative, ptet_error** error);
/* Budgets of size. What is asked is refined in an order that the file has, which keeps small what it was built for, up
 * to the first collapse that would pass a budget. The coarsest mesh and what focus regions need are there in any case.
 */
ptet_status ptet_request_set_max_tets(ptet_request* request, uint64_t tets, ptet_error** error);
ptet_status ptet_request_set_max_vertices(ptet_request* request, uint64_t vertices, ptet_error** error);
/* About how long a call may take, wall time. ptet_session_update leaves to the next update what it has not done: it
 * reads at least one block that it needs, and more as they seem to fit the time; what finding the cut takes is not
 * bounded. ptet_dataset_extract stops refining and gives what it has: two answers to such a request need not be the
 * same. */
ptet_status ptet_request_set_max_milliseconds(ptet_request* request, double milliseconds, ptet_error** error);
/* Bytes of the answer: positions, fields, tets (16 each) and boundary faces (12 each). */
ptet_status ptet_request_set_max_bytes(ptet_request* request, uint64_t bytes, ptet_error** error);

/* Focus regions: no tet or face that meets one has a larger error than the focus error, and no point of the original's
 * boundary in it is further from the mesh. That is 0 at first: the tets there are original ones. Regions are numbered
 * from 0 in the order in which they are added. `min`, `max`, `centre`, `normal`: three numbers each, mesh units. */
ptet_status ptet_request_add_focus_box(ptet_request* request, const double* min, const double* max, ptet_error** error);
/* `half_axes`: three times three numbers, from the centre to the middle of a side; mutually perpendicular. */
ptet_status ptet_request_add_focus_oriented_box(ptet_request* request, const double* centre, const double* half_axes,
                                                ptet_error** error);
ptet_status ptet_request_add_focus_sphere(ptet_request* request, const double* centre, double radius,
                                          ptet_error** error);
/* The points x with dot(normal, x) <= offset. */
ptet_status ptet_request_add_focus_half_space(ptet_request* request, const double* normal, double offset,
                                              ptet_error** error);
/* The error allowed in all focus regions of the request, also in those that are added later. It holds for every
 * governing field and, as the same fraction of the diagonal, for the domain; where it is absolute, as the fraction that
 * it is of the largest range of a governing field. */
ptet_status ptet_request_set_focus_error(ptet_request* request, double value, int32_t relative, ptet_error** error);
/* Outside of a region the error allowed grows: by this for every diagonal of distance from it. For all regions of the
 * request, also those that are added later. Unless it is called, nothing is asked outside. */
ptet_status ptet_request_set_focus_falloff(ptet_request* request, double value, int32_t relative, ptet_error** error);
/* The same for one region, which must have been added. */
ptet_status ptet_request_set_region_error(ptet_request* request, uint32_t region, double value, int32_t relative,
                                          ptet_error** error);
ptet_status ptet_request_set_region_falloff(ptet_request* request, uint32_t region, double value, int32_t relative,
                                            ptet_error** error);
/* Bounds on errors hold only where `field` (of vectors the Euclidean norm) may take values in [min, max]; min == max:
 * an isovalue. With several, where any of them may be met. */
ptet_status ptet_request_add_values(ptet_request* request, const char* field, double min, double max,
                                    ptet_error** error);

/* What a camera sees, in perspective. */
typedef struct ptet_view {
  uint64_t struct_size;
  double eye[3];
  double direction[3];   /* of any length but 0 */
  double up[3];          /* not parallel to the direction */
  double vertical_angle; /* of the whole picture, radians, below pi */
  uint32_t width;        /* pixels */
  uint32_t height;
  double max_pixels; /* largest domain error in the picture, pixels */
  double outside;    /* outside the picture errors may be so many times those allowed in it; >= 1; 0 or INFINITY:
                        nothing is asked there */
} ptet_view;
/* The struct is copied. Bounds on errors hold no more outside the picture, but for `outside`. */
ptet_status ptet_request_set_view(ptet_request* request, const ptet_view* view, ptet_error** error);
/* Not 0: also say which record made each tet (ptet_extraction_made_by), which reads all of the file. */
ptet_status ptet_request_set_origins(ptet_request* request, int32_t origins, ptet_error** error);
/* Not 0: vertices in the order of the mesh that the file was built from (ptet_extraction_input_vertices) and, where all
 * of it is there, tets and their corners, too, however these were oriented: what was given, byte for byte. Only of a
 * file that keeps it (ptet_dataset_info.has_input_order), not of a session: else PTET_BAD_ARGUMENT. */
ptet_status ptet_request_set_input_order(ptet_request* request, int32_t input_order, ptet_error** error);

/* ---- Extraction ---- */

/* The mesh that answers `request` (NULL: the original). Same request, same mesh, whatever was asked before, as long as
 * it is complete (ptet_extraction_info.complete) and no time was a budget.
 * `progress` may be NULL; `user` is handed to it.
 * Errors: PTET_BAD_ARGUMENT (a field that is not there or does not govern; a bound, box or radius that is negative, not
 * finite or empty; a view without a direction; an order that the file does not keep), PTET_CANCELLED,
 * PTET_OUT_OF_MEMORY, and where the input's order is asked for what reading it meets: PTET_IO_ERROR, PTET_CORRUPT_FILE,
 * PTET_LIMIT. Blocks that cannot be had only make the mesh coarser. */
ptet_status ptet_dataset_extract(const ptet_dataset* dataset, const ptet_request* request,
                                 ptet_progress_callback progress, void* user, ptet_extraction** extraction,
                                 ptet_error** error);
void ptet_extraction_free(ptet_extraction* extraction);

/* What kept the mesh from being finer. */
typedef int32_t ptet_limit;
enum {
  PTET_LIMITED_BY_NOTHING = 0,   /* it is the original mesh */
  PTET_LIMITED_BY_ERROR = 1,     /* the asked error was reached */
  PTET_LIMITED_BY_FOCUS = 2,     /* the focus was reached, nothing else was asked */
  PTET_LIMITED_BY_BUDGET = 3,    /* the next split, or the focus or base itself, does not fit the budget */
  PTET_LIMITED_BY_TIME = 4,      /* the time was up */
  PTET_LIMITED_BY_LOADING = 5,   /* blocks that are still to be read; ask again */
  PTET_LIMITED_BY_MEMORY = 6,    /* blocks that do not fit the memory allowed */
  PTET_LIMITED_BY_UNREADABLE = 7 /* blocks that cannot be read or decoded, see ptet_extraction_get_failure */
};
/* "error" and so on; "unknown" for any other number. */
const char* ptet_limit_name(ptet_limit limit);

typedef struct ptet_extraction_info {
  uint64_t struct_size;
  uint64_t vertices;
  uint64_t tets;
  uint64_t boundary_faces;
  uint32_t fields; /* those of the dataset, in its order */
  ptet_limit limited_by;
  double domain_error;    /* of this mesh, mesh units */
  uint64_t bytes_read;    /* from the file for the dataset so far, opening included */
  double seconds;         /* wall time of ptet_dataset_extract */
  uint64_t read_requests; /* how often the source was asked for the dataset so far */
  uint32_t failures;      /* blocks that could not be had, see ptet_extraction_get_failure */
  int32_t complete;       /* 0: blocks are missing, and the mesh is coarser there than was asked for. 1: none is; where
                           * time was what limited it, asking again may give more all the same */
} ptet_extraction_info;

typedef struct ptet_block_failure {
  uint64_t struct_size;
  const char* message;
  uint64_t byte_offset; /* of the block in the file */
  uint32_t block;
  ptet_status status; /* PTET_CORRUPT_FILE: damaged, for good; PTET_IO_ERROR: later requests try again */
} ptet_block_failure;

ptet_status ptet_extraction_get_info(const ptet_extraction* extraction, ptet_extraction_info* info, ptet_error** error);

/* `failure`: 0 to ptet_extraction_info.failures - 1. */
ptet_status ptet_extraction_get_failure(const ptet_extraction* extraction, uint32_t failure, ptet_block_failure* info,
                                        ptet_error** error);

/* A table of rows x components scalars of one type, row after row, in the machine's byte order. */
typedef struct ptet_array {
  uint64_t struct_size;
  const char* name; /* "" for positions */
  const void* data; /* NULL when there are no rows */
  uint64_t rows;    /* one for each vertex of the extraction */
  uint32_t components;
  ptet_scalar_type type;
} ptet_array;

ptet_status ptet_extraction_get_positions(const ptet_extraction* extraction, ptet_array* positions, ptet_error** error);
/* `field` is its number in the dataset. */
ptet_status ptet_extraction_get_field(const ptet_extraction* extraction, uint32_t field, ptet_array* values,
                                      ptet_error** error);

/* Four vertices for each tet, positively oriented: det(b - a, c - a, d - a) > 0; as they were given where the request
 * asked for the order of the input. */
const uint32_t* ptet_extraction_tets(const ptet_extraction* extraction);
/* Three vertices for each boundary face, seen counter-clockwise from outside. */
const uint32_t* ptet_extraction_boundary_faces(const ptet_extraction* extraction);
/* For each vertex its number in the file, which is the same in every extraction. */
const uint32_t* ptet_extraction_vertices_in_file(const ptet_extraction* extraction);
/* For each vertex its number in the mesh that the file was built from, ascending. NULL when the request did not ask for
 * it (ptet_request_set_input_order). */
const uint32_t* ptet_extraction_input_vertices(const ptet_extraction* extraction);
/* For each tet the record that made it, UINT32_MAX when it is an original one, whose error is 0. NULL when the request
 * did not ask for it (ptet_request_set_origins). */
const uint32_t* ptet_extraction_made_by(const ptet_extraction* extraction);

/* What the record that made a tet says of it. */
typedef int32_t ptet_origin_value;
enum {
  PTET_ORIGIN_FIELD_ERROR = 0,  /* largest error of the field among the tets that the record made, field units */
  PTET_ORIGIN_DOMAIN_ERROR = 1, /* likewise of the boundary faces, mesh units */
  PTET_ORIGIN_LEVEL = 2,        /* n: a budget undoes the collapse from 1/2^n to 1/2^(n-1) of the vertices on */
  PTET_ORIGIN_GENERATION = 3    /* how many splits must be made one after the other before that of the record can be */
};
/* Fills `values` for `count` records as ptet_extraction_made_by and ptet_session_made_by have them: 0 for original tets
 * (UINT32_MAX), NaN for records that are not in memory. `field`: for errors of a field its number in the dataset.
 * Errors: PTET_BAD_ARGUMENT (no such record; a field that is not there or does not govern). */
ptet_status ptet_dataset_get_origin_values(const ptet_dataset* dataset, const uint32_t* made_by, uint64_t count,
                                           ptet_origin_value what, uint32_t field, double* values, ptet_error** error);

/* The largest error of the field in this mesh, in its units: in a file built with exact evaluation no point that the
 * mesh covers has a larger one. NaN when the field does not govern, or is none. */
double ptet_extraction_field_error(const ptet_extraction* extraction, uint32_t field);
/* The same among the tets and boundary faces of a part of the mesh that the request names: what meets its focus region
 * `number`; what may take its values of interest `number`, widened by their own error; what meets the picture of its
 * view (`number` 0); with the faces that may stand for a part of the original there. NaN where the request had no such
 * part, or the field does not govern. */
typedef int32_t ptet_part;
enum { PTET_PART_FOCUS = 0, PTET_PART_VALUES = 1, PTET_PART_VIEW = 2 };
double ptet_extraction_part_field_error(const ptet_extraction* extraction, ptet_part part, uint32_t number,
                                        uint32_t field);
double ptet_extraction_part_domain_error(const ptet_extraction* extraction, ptet_part part, uint32_t number);
/* Not 0 where the mesh, of the request that it answers, has nothing of such a part: no tet meets the focus region, no
 * point has a value of interest, no tet is in the picture of the view. As a rule a slip of the user's, who wants to be
 * told. Of a mesh that a budget or time cut short, or that is not complete, only for a region or view that is farther
 * from it than its domain error: what is missing may have the others. 0 for NULL, and where the request has no such
 * part. Cost: a look at every tet at most. */
int32_t ptet_extraction_is_unmet(const ptet_extraction* extraction, const ptet_request* request, ptet_part part,
                                 uint32_t number);
/* The largest domain error in the picture as the view counts it, pixels; INFINITY where a face with an error comes as
 * near to the eye as the error is large, 0 without a view. */
double ptet_extraction_pixels_in_view(const ptet_extraction* extraction);
/* The root mean square of the field's error over that part of the original domain which the mesh covers, in the field's
 * units; NaN when the build did not measure it. */
double ptet_extraction_rms_error(const ptet_extraction* extraction, uint32_t field);
/* So much of the original's volume the mesh covers at least, from 0 to 1; NaN when the build did not measure it. No
 * bound where the original overlaps itself. */
double ptet_extraction_covered(const ptet_extraction* extraction);

/* ---- Sessions: a mesh that follows its requests, for viewers ---- */

/* Goes from mesh to mesh by what differs, so that an update costs what it changes. Tets, boundary faces and vertices
 * keep their slots while they stay: a copy elsewhere, as on a graphics card, needs only the changed slots. Any number
 * of sessions may share a dataset, each used by one thread at a time. */
typedef struct ptet_session ptet_session;

/* What an update did and what mesh there is now. The pointers are valid until the next update. */
typedef struct ptet_session_changes {
  uint64_t struct_size;
  /* Slots that were taken, freed, or hold something else now; each once, in no order. */
  const uint32_t* changed_tets;
  const uint32_t* changed_faces;
  const uint32_t* changed_vertices;
  uint64_t changed_tet_count;
  uint64_t changed_face_count;
  uint64_t changed_vertex_count;
  uint64_t tets; /* of the mesh as it is now */
  uint64_t boundary_faces;
  uint64_t vertices;
  /* By splits and collapses; tets that only got another corner are not counted. The first update adds the coarsest
   * mesh as well, and so does one that starts over, which does not count what it leaves behind. */
  uint64_t tets_added;
  uint64_t tets_removed;
  uint64_t vertices_added;
  uint64_t vertices_removed;
  uint64_t splits;
  uint64_t collapses;
  double domain_error; /* of the mesh as it is now, mesh units */
  double seconds;      /* wall time of the call */
  ptet_limit limited_by;
  int32_t complete; /* 1: this is the mesh that was asked for; 0: the next update with the same request goes on */
  /* 1: tets, faces and vertices were moved to the first slots; those in use are all among the changed ones, and there
   * may be fewer slots. That happens when the update is complete and of more than 4096 tet slots less than one in four
   * is used, and when the session had to start over. 0: what stays in the mesh keeps its slot. */
  int32_t renumbered;
  uint32_t failures; /* blocks that could not be had, see ptet_session_get_failure */
} ptet_session_changes;

/* Begins with the coarsest mesh. The dataset may be freed before the session. */
ptet_status ptet_session_open(const ptet_dataset* dataset, ptet_session** session, ptet_error** error);
void ptet_session_free(ptet_session* session);
/* Makes the mesh that answers `request` (NULL: the original): once it is complete, that of ptet_dataset_extract,
 * whatever came before. `progress` and `changes` may be NULL; `progress` is called first and while parts of the file
 * are read or waited for, and must not use the session. Errors as of ptet_dataset_extract;
 * after PTET_BAD_ARGUMENT the mesh is as it was, after PTET_CANCELLED too, unless the session had to start over; after
 * others its slots are of no use before the next update, which starts over. */
ptet_status ptet_session_update(ptet_session* session, const ptet_request* request, ptet_progress_callback progress,
                                void* user, ptet_session_changes* changes, ptet_error** error);

/* `failure`: 0 to ptet_session_changes.failures of the last update - 1; valid until the next one. */
ptet_status ptet_session_get_failure(const ptet_session* session, uint32_t failure, ptet_block_failure* info,
                                     ptet_error** error);

/* The mesh by slots, valid until the next update; `slots`, unless NULL, is given their number. Unused slots are
 * UINT32_MAX throughout. */
/* Four vertex slots for each tet slot, positively oriented. */
const uint32_t* ptet_session_tets(const ptet_session* session, uint64_t* slots);
/* Three for each face slot, seen counter-clockwise from outside. */
const uint32_t* ptet_session_boundary_faces(const ptet_session* session, uint64_t* slots);
/* For each tet slot the record that made the tet, as ptet_extraction_made_by has it; UINT32_MAX for unused slots, too.
 * NULL unless the last request asked for it (ptet_request_set_origins). A slot of which it is told otherwise now is
 * among the changed ones; when it is asked for after a request that did not, all in use are. */
const uint32_t* ptet_session_made_by(const ptet_session* session, uint64_t* slots);
/* For each vertex slot the vertex's number in the file. */
const uint32_t* ptet_session_vertices_in_file(const ptet_session* session, uint64_t* slots);
/* A row for each vertex slot; those of unused slots mean nothing. */
ptet_status ptet_session_get_positions(const ptet_session* session, ptet_array* positions, ptet_error** error);
ptet_status ptet_session_get_field(const ptet_session* session, uint32_t field, ptet_array* values, ptet_error** error);
/* As of an extraction; NaN before the first update. */
double ptet_session_field_error(const ptet_session* session, uint32_t field);
double ptet_session_rms_error(const ptet_session* session, uint32_t field);
double ptet_session_covered(const ptet_session* session);
/* The mesh without slots, as ptet_dataset_extract gives it. */
ptet_status ptet_session_extract(const ptet_session* session, ptet_extraction** extraction, ptet_error** error);

#ifdef __cplusplus
}
#endif
/* NOLINTEND */

#endif
