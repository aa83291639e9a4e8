/* The C interface of the builder (the library ptet_build): from arrays in memory to a .ptet file, or to its bytes in
 * memory, which ptet_dataset_open_memory opens. The rules of ptet.h hold: handles, errors, structs, threads. */
#ifndef PTET_PTET_BUILD_H
#define PTET_PTET_BUILD_H

#include "ptet/ptet.h"

/* NOLINTBEGIN: the names and idioms of C */
#ifdef __cplusplus
extern "C" {
#endif

/* What tells which collapse comes next. */
typedef int32_t ptet_prediction;
enum {
  PTET_PREDICT_LOCAL = 0,        /* the error at the removed vertex, added up over the collapses */
  PTET_PREDICT_GRADIENT = 1,     /* how much the gradient of the field differs along the edge */
  PTET_PREDICT_QUADRIC = 2,      /* quadrics of field and domain: fast */
  PTET_PREDICT_WEIGHTED_SUM = 3, /* gradient, volume and edge length terms added up */
  PTET_PREDICT_PER_TET = 4,      /* deviations added up tet by tet */
  PTET_PREDICT_SIMULATE = 5,     /* every collapse is tried and its error measured */
  PTET_PREDICT_EXACT = 6         /* the best few are tried and measured everywhere (at first) */
};

/* Where the errors that the file states are measured. */
typedef int32_t ptet_evaluation;
enum {
  PTET_EVALUATE_NONE = 0,     /* nowhere: what the prediction believes */
  PTET_EVALUATE_VERTICES = 1, /* at removed vertices: fast; between them the true error may be larger */
  PTET_EVALUATE_SAMPLES = 2,  /* at removed vertices and samples */
  PTET_EVALUATE_EXACT = 3     /* everywhere: bounds at every point (at first) */
};

/* Which field error is kept small, where collapses are tried. */
typedef int32_t ptet_objective;
enum { PTET_OBJECTIVE_MAXIMUM = 0, PTET_OBJECTIVE_ROOT_MEAN_SQUARE = 1, PTET_OBJECTIVE_BOTH = 2 /* at first */ };

typedef struct ptet_builder ptet_builder;
typedef struct ptet_bytes ptet_bytes;

ptet_builder* ptet_builder_new(void); /* NULL when memory is out */
void ptet_builder_free(ptet_builder* builder);

/* ---- The mesh. Arrays are copied. Points, then tets and fields in any order; each of the two once. ---- */

/* `xyz`: 3 x `count` scalars of `type`. */
ptet_status ptet_builder_set_points(ptet_builder* builder, ptet_scalar_type type, uint64_t count, const void* xyz,
                                    ptet_error** error);
/* `corners`: 4 x `count` numbers of points, 0-based, in any orientation. Whether they are a mesh is found by the build.
 */
ptet_status ptet_builder_set_tets(ptet_builder* builder, uint64_t count, const uint32_t* corners, ptet_error** error);
/* `values`: one row of 1 to 1024 `components` for each point; they come back bit for bit. A name can be used once. */
ptet_status ptet_builder_add_field(ptet_builder* builder, const char* name, ptet_scalar_type type, uint32_t components,
                                   const void* values, ptet_error** error);

/* ---- Options. Whether a number makes sense is found by the build. ---- */

/* The field's errors are kept small and stated. When it is called for none: those of every floating-point field,
 * and if there is none of every field. */
ptet_status ptet_builder_add_governing_field(ptet_builder* builder, const char* name, ptet_error** error);
/* No collapse may have a larger error of the field, a governing one; "" or NULL: of any governing one. `relative` as in
 * requests. */
ptet_status ptet_builder_add_max_field_error(ptet_builder* builder, const char* name, double value, int32_t relative,
                                             ptet_error** error);
/* At first 2% of the diagonal. */
ptet_status ptet_builder_set_max_domain_error(ptet_builder* builder, double value, int32_t relative,
                                              ptet_error** error);
/* How far down to go: a number of vertices, or a fraction of them when it is below 1. At first 0.01. */
ptet_status ptet_builder_set_target_vertices(ptet_builder* builder, double vertices, ptet_error** error);
/* "Exact" needs PTET_EVALUATE_EXACT, "simulate" any evaluation but none: whoever wants less evaluation than at first
 * has to set another prediction, too. */
ptet_status ptet_builder_set_prediction(ptet_builder* builder, ptet_prediction prediction, ptet_error** error);
ptet_status ptet_builder_set_evaluation(ptet_builder* builder, ptet_evaluation evaluation, ptet_error** error);
ptet_status ptet_builder_set_objective(ptet_builder* builder, ptet_objective objective, ptet_error** error);
/* Floor of the shape measure 6 sqrt(2) V / Lmax^3 (1: regular), in [0, 1). At first 0.001, less for meshes with flat
 * parts. */
ptet_status ptet_builder_set_min_quality(ptet_builder* builder, double quality, ptet_error** error);
/* Cap on the tets and boundary faces around a vertex, in 8 .. 4096. At first 64. */
ptet_status ptet_builder_set_max_star(ptet_builder* builder, uint32_t cells, ptet_error** error);
/* The best part of the candidates that a round may take; in (0, 1]. At first 0.3. */
ptet_status ptet_builder_set_round_fraction(ptet_builder* builder, double fraction, ptet_error** error);
/* 0, as at first: as many as the machine has. The bytes that come out do not depend on it. */
ptet_status ptet_builder_set_threads(ptet_builder* builder, uint32_t threads, ptet_error** error);
/* The most resident memory, in bytes, that the process may come to; 0, as at first: no limit. A build that would take
 * more is refused before it takes it (PTET_LIMIT). The copy of the mesh in the builder counts. */
ptet_status ptet_builder_set_memory_limit(ptet_builder* builder, uint64_t bytes, ptet_error** error);
/* 1 .. 65536; more than 1: the mesh is cut in so many pieces, which are collapsed one after the other before the whole.
 * At first 1. The bytes that come out depend on it; the guarantees do not. */
ptet_status ptet_builder_set_pieces(ptet_builder* builder, uint32_t pieces, ptet_error** error);
/* Not 0: first make one point of those that have the same place and the same values in every field, bit for bit: of the
 * points that parts of a mesh share. At first 0. */
ptet_status ptet_builder_set_weld(ptet_builder* builder, int32_t weld, ptet_error** error);
/* The same, and what rounding has set apart at the boundary: points no farther apart than `distance`, in mesh units or,
 * if `relative` is not 0, as a part of the bounding box's diagonal, whose values differ by no larger a part of their
 * field's range. A thousandth of the diagonal at most. 0: bit for bit. */
ptet_status ptet_builder_set_weld_within(ptet_builder* builder, double distance, int32_t relative, ptet_error** error);
/* Not 0: also keep in what order vertices, tets and their corners stand, so that they come back in it
 * (ptet_request_set_input_order). Takes some 2 bytes a vertex and up to 3 a tet, 4 of very large meshes. At first 0. */
ptet_status ptet_builder_set_keep_order(ptet_builder* builder, int32_t keep_order, ptet_error** error);
/* Name and hash of where the mesh comes from, kept in the file as they are, but for bytes that
 * are not UTF-8: these are read as Latin-1. Either may be NULL. */
ptet_status ptet_builder_set_source(ptet_builder* builder, const char* name, const char* hash, ptet_error** error);

/* ---- The build. The builder stays as it is, and can build again. ---- */

typedef struct ptet_build_report {
  uint64_t struct_size;
  uint64_t input_vertices;
  uint64_t input_tets;
  uint64_t base_vertices; /* that tets of the coarsest mesh use */
  uint64_t base_tets;
  uint64_t records;
  uint64_t file_bytes;
  double domain_error;        /* largest of any collapse, mesh units */
  double seconds;             /* wall time */
  uint64_t peak_memory_bytes; /* the most that the process had resident by then; 0: not known */
} ptet_build_report;

/* Writes the file, whole or not at all: an older one of that name stays until the new one is there.
 * `progress` and `report` may be NULL.
 * Errors: PTET_BAD_ARGUMENT (options), PTET_BAD_INPUT (the mesh, with the first thing wrong), PTET_LIMIT,
 * PTET_IO_ERROR, PTET_CANCELLED, PTET_OUT_OF_MEMORY. Same mesh and options: same bytes. */
ptet_status ptet_builder_build_file(const ptet_builder* builder, const char* path, ptet_progress_callback progress,
                                    void* user, ptet_build_report* report, ptet_error** error);
/* The same bytes, in memory. */
ptet_status ptet_builder_build_memory(const ptet_builder* builder, ptet_progress_callback progress, void* user,
                                      ptet_bytes** bytes, ptet_build_report* report, ptet_error** error);
const void* ptet_bytes_data(const ptet_bytes* bytes);
uint64_t ptet_bytes_size(const ptet_bytes* bytes);
void ptet_bytes_free(ptet_bytes* bytes);

#ifdef __cplusplus
}
#endif
/* NOLINTEND */

#endif
