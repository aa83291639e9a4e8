/* The C interface, used as a C program uses it: every function, what it answers and what it refuses. The mesh is a
 * block of 6 x 6 x 6 cubes, each cut into six tets, with a float32 field, a float64 vector and a uint8 marker. */
#include "ptet/ptet.h"
#include "ptet/ptet_build.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int checks = 0, failures = 0;

#define CHECK(condition)                                                                                               \
  do {                                                                                                                 \
    ++checks;                                                                                                          \
    if (!(condition)) {                                                                                                \
      ++failures;                                                                                                      \
      fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                                          \
    }                                                                                                                  \
  } while (0)

/* What cannot go on without: a test after it would only crash. */
#define REQUIRE(condition)                                                                                             \
  do {                                                                                                                 \
    CHECK(condition);                                                                                                  \
    if (!(condition)) exit(1);                                                                                         \
  } while (0)

/* The call succeeded, and left no error. */
#define SUCCEEDS(call)                                                                                                 \
  do {                                                                                                                 \
    ptet_error* error = NULL;                                                                                          \
    const ptet_status status = (call);                                                                                 \
    if (status != PTET_OK) fprintf(stderr, "%s\n", ptet_error_message(error));                                         \
    CHECK(status == PTET_OK && error == NULL);                                                                         \
    ptet_error_free(error);                                                                                            \
  } while (0)

/* The call failed in this way, and its error says so and contains this. The call names `&error`. */
#define FAILS(wanted, part, call)                                                                                      \
  do {                                                                                                                 \
    ptet_error* error = NULL;                                                                                          \
    const ptet_status status = (call);                                                                                 \
    CHECK(status == (wanted));                                                                                         \
    CHECK(error != NULL && ptet_error_status(error) == (wanted));                                                      \
    if (strstr(ptet_error_message(error), (part)) == NULL) fprintf(stderr, "said: %s\n", ptet_error_message(error));   \
    CHECK(strstr(ptet_error_message(error), (part)) != NULL);                                                          \
    ptet_error_free(error);                                                                                            \
  } while (0)

enum { CUBES = 6, SIDE = CUBES + 1, POINTS = SIDE * SIDE * SIDE, TETS = 6 * CUBES * CUBES * CUBES };

static float xyz[3 * POINTS];
static uint32_t corners[4 * TETS];
static float pressure[POINTS];
static double flow[3 * POINTS];
static uint8_t marker[POINTS];

static uint32_t point_at(const uint32_t at[3]) {
  return at[0] + SIDE * (at[1] + SIDE * at[2]);
}

static void make_mesh(void) {
  /* The six ways from one corner of a cube to the opposite one, along its edges; odd ways are turned round. */
  static const uint32_t ways[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
  uint32_t* corner = corners;
  for (uint32_t p = 0; p < POINTS; ++p) {
    const uint32_t at[3] = {p % SIDE, p / SIDE % SIDE, p / SIDE / SIDE};
    for (int i = 0; i < 3; ++i) {
      xyz[3 * p + (uint32_t)i] = (float)at[i];
      flow[3 * p + (uint32_t)i] = cos(0.3 * (at[0] + (i + 1) * at[1])) - 0.1 * at[2];
    }
    pressure[p] = sinf((float)(at[0] + 2 * at[1]) * 0.4F) + (float)(at[2] * at[2]) * 0.05F;
    marker[p] = (uint8_t)(p % 251);
    if (at[0] == CUBES || at[1] == CUBES || at[2] == CUBES) continue;
    for (int way = 0; way < 6; ++way) {
      uint32_t walk[3] = {at[0], at[1], at[2]};
      corner[0] = p;
      for (int step = 0; step < 3; ++step) {
        ++walk[ways[way][step]];
        corner[way < 3 || step == 0 ? step + 1 : 4 - step] = point_at(walk);
      }
      corner += 4;
    }
  }
  REQUIRE(corner == corners + 4 * TETS);
}

/* Counts its calls, and cancels at the one that is asked for. */
struct counter {
  uint64_t calls, cancel_at;
};

static int32_t count_progress(const char* stage, uint64_t done, uint64_t total, void* user) {
  struct counter* counter = user;
  CHECK(stage != NULL && strlen(stage) > 0);
  CHECK(total == 0 || done <= total);
  return ++counter->calls == counter->cancel_at;
}

static ptet_builder* quick_builder(void) {
  ptet_builder* builder = ptet_builder_new();
  REQUIRE(builder != NULL);
  SUCCEEDS(ptet_builder_set_points(builder, PTET_FLOAT32, POINTS, xyz, &error));
  SUCCEEDS(ptet_builder_set_tets(builder, TETS, corners, &error));
  SUCCEEDS(ptet_builder_add_field(builder, "pressure", PTET_FLOAT32, 1, pressure, &error));
  SUCCEEDS(ptet_builder_add_field(builder, "flow", PTET_FLOAT64, 3, flow, &error));
  SUCCEEDS(ptet_builder_add_field(builder, "marker", PTET_UINT8, 1, marker, &error));
  SUCCEEDS(ptet_builder_set_prediction(builder, PTET_PREDICT_QUADRIC, &error));
  SUCCEEDS(ptet_builder_set_target_vertices(builder, 0.1, &error));
  return builder;
}

static ptet_bytes* build(const ptet_builder* builder) {
  ptet_bytes* bytes = NULL;
  SUCCEEDS(ptet_builder_build_memory(builder, NULL, NULL, &bytes, NULL, &error));
  REQUIRE(bytes != NULL && ptet_bytes_size(bytes) > 0);
  return bytes;
}

static void test_versions_and_names(void) {
  CHECK(ptet_abi_version() == PTET_ABI_VERSION);
  CHECK(strcmp(ptet_version(), PTET_TEST_VERSION) == 0);
  CHECK(strcmp(ptet_status_name(PTET_OK), "ok") == 0);
  CHECK(strcmp(ptet_status_name(99), "unknown") == 0);
  static const ptet_status all[] = {PTET_OK,        PTET_INTERNAL_ERROR, PTET_BAD_ARGUMENT,
                                    PTET_BAD_INPUT, PTET_CORRUPT_FILE,   PTET_LIMIT,
                                    PTET_IO_ERROR,  PTET_OUT_OF_MEMORY,  PTET_CANCELLED};
  for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
    for (size_t j = 0; j < i; ++j)
      CHECK(strcmp(ptet_status_name(all[i]), ptet_status_name(all[j])) != 0);
  CHECK(strcmp(ptet_limit_name(PTET_LIMITED_BY_NOTHING), "nothing") == 0);
  CHECK(strcmp(ptet_limit_name(PTET_LIMITED_BY_ERROR), "error") == 0);
  CHECK(strcmp(ptet_limit_name(PTET_LIMITED_BY_FOCUS), "focus") == 0);
  CHECK(strcmp(ptet_limit_name(PTET_LIMITED_BY_BUDGET), "budget") == 0);
  CHECK(strcmp(ptet_limit_name(PTET_LIMITED_BY_TIME), "time") == 0);
  CHECK(strcmp(ptet_limit_name(-7), "unknown") == 0);
}

/* The builder: what it refuses, before there is a mesh in it and afterwards. */
static void test_builder(void) {
  ptet_builder* builder = ptet_builder_new();
  REQUIRE(builder != NULL);
  ptet_bytes* bytes = NULL;
  FAILS(PTET_BAD_INPUT, "tet", ptet_builder_build_memory(builder, NULL, NULL, &bytes, NULL, &error));
  CHECK(bytes == NULL);

  FAILS(PTET_BAD_ARGUMENT, "points before", ptet_builder_add_field(builder, "f", PTET_FLOAT32, 1, pressure, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_builder_set_points(builder, PTET_FLOAT32, 1, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "scalar type 10", ptet_builder_set_points(builder, 10, POINTS, xyz, &error));
  FAILS(PTET_BAD_ARGUMENT, "scalar type -1", ptet_builder_set_points(builder, -1, POINTS, xyz, &error));
  FAILS(PTET_LIMIT, "points", ptet_builder_set_points(builder, PTET_FLOAT32, UINT64_MAX, xyz, &error));
  SUCCEEDS(ptet_builder_set_points(builder, PTET_FLOAT32, POINTS, xyz, &error));
  FAILS(PTET_BAD_ARGUMENT, "already", ptet_builder_set_points(builder, PTET_FLOAT32, POINTS, xyz, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_builder_set_tets(builder, 1, NULL, &error));
  FAILS(PTET_LIMIT, "tets", ptet_builder_set_tets(builder, UINT64_MAX, corners, &error));
  SUCCEEDS(ptet_builder_set_tets(builder, TETS, corners, &error));
  FAILS(PTET_BAD_ARGUMENT, "already", ptet_builder_set_tets(builder, TETS, corners, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_builder_add_field(builder, NULL, PTET_FLOAT32, 1, pressure, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_builder_add_field(builder, "f", PTET_FLOAT32, 1, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "empty", ptet_builder_add_field(builder, "", PTET_FLOAT32, 1, pressure, &error));
  FAILS(PTET_BAD_ARGUMENT, "components", ptet_builder_add_field(builder, "f", PTET_FLOAT32, 0, pressure, &error));
  FAILS(PTET_BAD_ARGUMENT, "components", ptet_builder_add_field(builder, "f", PTET_FLOAT32, 1025, pressure, &error));
  FAILS(PTET_BAD_ARGUMENT, "scalar type", ptet_builder_add_field(builder, "f", 99, 1, pressure, &error));
  SUCCEEDS(ptet_builder_add_field(builder, "f", PTET_FLOAT32, 1, pressure, &error));
  FAILS(PTET_BAD_ARGUMENT, "already", ptet_builder_add_field(builder, "f", PTET_FLOAT32, 1, pressure, &error));

  FAILS(PTET_BAD_ARGUMENT, "prediction 7", ptet_builder_set_prediction(builder, 7, &error));
  FAILS(PTET_BAD_ARGUMENT, "evaluation -1", ptet_builder_set_evaluation(builder, -1, &error));
  FAILS(PTET_BAD_ARGUMENT, "objective 3", ptet_builder_set_objective(builder, 3, &error));
  SUCCEEDS(ptet_builder_set_prediction(builder, PTET_PREDICT_QUADRIC, &error));
  SUCCEEDS(ptet_builder_set_evaluation(builder, PTET_EVALUATE_VERTICES, &error));

  /* Options that are numbers are looked at by the build: each is spoilt and set right again. */
  SUCCEEDS(ptet_builder_set_target_vertices(builder, NAN, &error));
  FAILS(PTET_BAD_ARGUMENT, "target", ptet_builder_build_memory(builder, NULL, NULL, &bytes, NULL, &error));
  SUCCEEDS(ptet_builder_set_target_vertices(builder, 0.5, &error));
  SUCCEEDS(ptet_builder_set_min_quality(builder, 2, &error));
  FAILS(PTET_BAD_ARGUMENT, "quality", ptet_builder_build_memory(builder, NULL, NULL, &bytes, NULL, &error));
  SUCCEEDS(ptet_builder_set_min_quality(builder, 0.01, &error));
  SUCCEEDS(ptet_builder_set_max_star(builder, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "star", ptet_builder_build_memory(builder, NULL, NULL, &bytes, NULL, &error));
  SUCCEEDS(ptet_builder_set_max_star(builder, 48, &error));
  SUCCEEDS(ptet_builder_set_round_fraction(builder, 0, &error));
  FAILS(PTET_BAD_ARGUMENT, "round", ptet_builder_build_memory(builder, NULL, NULL, &bytes, NULL, &error));
  SUCCEEDS(ptet_builder_set_round_fraction(builder, 0.2, &error));
  SUCCEEDS(ptet_builder_set_max_domain_error(builder, -1, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "domain", ptet_builder_build_memory(builder, NULL, NULL, &bytes, NULL, &error));
  SUCCEEDS(ptet_builder_set_max_domain_error(builder, 0.05, 1, &error));
  SUCCEEDS(ptet_builder_set_pieces(builder, 0, &error));
  FAILS(PTET_BAD_ARGUMENT, "pieces", ptet_builder_build_memory(builder, NULL, NULL, &bytes, NULL, &error));
  SUCCEEDS(ptet_builder_set_pieces(builder, 3, &error));
  ptet_bytes_free(build(builder));
  SUCCEEDS(ptet_builder_set_pieces(builder, 1, &error));
  SUCCEEDS(ptet_builder_set_threads(builder, 1, &error));
  SUCCEEDS(ptet_builder_set_memory_limit(builder, 1000, &error));
  FAILS(PTET_LIMIT, "of memory", ptet_builder_build_memory(builder, NULL, NULL, &bytes, NULL, &error));
  SUCCEEDS(ptet_builder_set_memory_limit(builder, (uint64_t)1 << 40, &error));
  bytes = build(builder);
  ptet_bytes_free(bytes);

  SUCCEEDS(ptet_builder_add_governing_field(builder, "none such", &error));
  FAILS(PTET_BAD_ARGUMENT, "none such", ptet_builder_build_memory(builder, NULL, NULL, &bytes, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_builder_add_governing_field(builder, NULL, &error));

  /* Where things go, and the builder itself. */
  ptet_build_report report = {0};
  FAILS(PTET_BAD_ARGUMENT, "struct_size", ptet_builder_build_memory(builder, NULL, NULL, &bytes, &report, &error));
  FAILS(PTET_BAD_ARGUMENT, "struct_size", ptet_builder_build_file(builder, "x", NULL, NULL, &report, &error));
  FAILS(PTET_BAD_ARGUMENT, "NULL", ptet_builder_build_memory(builder, NULL, NULL, NULL, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "path is NULL", ptet_builder_build_file(builder, NULL, NULL, NULL, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_build_file(NULL, "x", NULL, NULL, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_build_memory(NULL, NULL, NULL, &bytes, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_points(NULL, PTET_FLOAT32, POINTS, xyz, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_tets(NULL, TETS, corners, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_add_field(NULL, "f", PTET_FLOAT32, 1, pressure, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_add_governing_field(NULL, "f", &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_add_max_field_error(NULL, "f", 1, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_max_domain_error(NULL, 1, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_target_vertices(NULL, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_prediction(NULL, 0, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_evaluation(NULL, 0, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_objective(NULL, 0, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_min_quality(NULL, 0, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_max_star(NULL, 0, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_round_fraction(NULL, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_threads(NULL, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_memory_limit(NULL, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_pieces(NULL, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_weld(NULL, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_keep_order(NULL, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_source(NULL, "a", "b", &error));
  CHECK(ptet_builder_set_threads(NULL, 1, NULL) == PTET_BAD_ARGUMENT); /* nobody wants the error */
  CHECK(ptet_bytes_data(NULL) == NULL && ptet_bytes_size(NULL) == 0);
  ptet_bytes_free(NULL);
  ptet_builder_free(NULL);
  ptet_builder_free(builder);

  ptet_builder* spoilt = ptet_builder_new();
  uint32_t tet[4] = {0, 1, SIDE, POINTS};
  SUCCEEDS(ptet_builder_set_points(spoilt, PTET_FLOAT32, POINTS, xyz, &error));
  SUCCEEDS(ptet_builder_set_tets(spoilt, 1, tet, &error));
  FAILS(PTET_BAD_INPUT, "", ptet_builder_build_memory(spoilt, NULL, NULL, &bytes, NULL, &error));
  ptet_builder_free(spoilt);
}

/* A limit on a field's error is kept, and what governs is what was asked. */
static void test_builder_limits(void) {
  ptet_builder* builder = quick_builder();
  SUCCEEDS(ptet_builder_add_governing_field(builder, "pressure", &error));
  SUCCEEDS(ptet_builder_add_max_field_error(builder, NULL, 0.02, 1, &error));
  SUCCEEDS(ptet_builder_set_objective(builder, PTET_OBJECTIVE_MAXIMUM, &error));
  SUCCEEDS(ptet_builder_set_source(builder, "a block", NULL, &error));
  ptet_bytes* bytes = build(builder);
  ptet_dataset* dataset = NULL;
  SUCCEEDS(ptet_dataset_open_memory(ptet_bytes_data(bytes), ptet_bytes_size(bytes), NULL, &dataset, &error));
  ptet_bytes_free(bytes); /* the dataset has its own copy */
  ptet_builder_free(builder);
  REQUIRE(dataset != NULL);
  ptet_field_info field = {.struct_size = sizeof field};
  SUCCEEDS(ptet_dataset_get_field(dataset, 0, &field, &error));
  CHECK(field.governing == 1);
  CHECK(field.max_error > 0 && field.max_error <= 0.02 * 1.05 * field.range);
  CHECK(field.max_rms > 0 && field.max_rms < field.max_error);
  SUCCEEDS(ptet_dataset_get_field(dataset, 1, &field, &error));
  CHECK(field.governing == 0 && isnan(field.max_error) && isnan(field.max_rms));
  CHECK(strstr(ptet_dataset_provenance(dataset), "a block") != NULL);
  ptet_dataset_free(dataset);
}

static void test_build_progress(const ptet_builder* builder, const ptet_bytes* expected) {
  struct counter counter = {0, 0};
  ptet_build_report report = {.struct_size = sizeof report};
  ptet_bytes* bytes = NULL;
  SUCCEEDS(ptet_builder_build_memory(builder, count_progress, &counter, &bytes, &report, &error));
  REQUIRE(bytes != NULL && counter.calls > 2);
  CHECK(ptet_bytes_size(bytes) == ptet_bytes_size(expected)); /* a builder can build again */
  CHECK(memcmp(ptet_bytes_data(bytes), ptet_bytes_data(expected), ptet_bytes_size(expected)) == 0);
  CHECK(report.struct_size == sizeof report);
  CHECK(report.input_vertices == POINTS && report.input_tets == TETS);
  CHECK(report.base_vertices + report.records == POINTS && report.records > 0);
  CHECK(report.base_tets > 0 && report.base_tets < TETS);
  CHECK(report.file_bytes == ptet_bytes_size(bytes));
  CHECK(report.domain_error >= 0 && report.seconds > 0 && report.peak_memory_bytes > 0);
  ptet_bytes_free(bytes);
  const uint64_t calls = counter.calls;
  for (uint64_t at = 1; at <= calls; at += calls / 3) {
    counter = (struct counter){0, at};
    FAILS(PTET_CANCELLED, "cancelled",
          ptet_builder_build_memory(builder, count_progress, &counter, &bytes, &report, &error));
    CHECK(bytes == NULL && counter.calls == at);
  }
}

static void test_build_file(const ptet_builder* builder, const ptet_bytes* expected) {
  static const char path[] = "c_interface_test.ptet";
  remove(path);
  struct counter counter = {0, 3};
  FAILS(PTET_CANCELLED, "", ptet_builder_build_file(builder, path, count_progress, &counter, NULL, &error));
  FILE* left = fopen(path, "rb");
  CHECK(left == NULL);
  FAILS(PTET_IO_ERROR, "no_such_folder",
        ptet_builder_build_file(builder, "no_such_folder/mesh.ptet", NULL, NULL, NULL, &error));
  ptet_build_report report = {.struct_size = sizeof report};
  SUCCEEDS(ptet_builder_build_file(builder, path, NULL, NULL, &report, &error));
  CHECK(report.file_bytes == ptet_bytes_size(expected));

  ptet_dataset *from_file = NULL, *none = NULL;
  SUCCEEDS(ptet_dataset_open(path, NULL, &from_file, &error));
  ptet_dataset_info info = {.struct_size = sizeof info};
  SUCCEEDS(ptet_dataset_get_info(from_file, &info, &error));
  CHECK(info.file_bytes == ptet_bytes_size(expected) && info.vertices == POINTS);
  ptet_dataset_free(from_file);
  FAILS(PTET_IO_ERROR, "no_such_file", ptet_dataset_open("no_such_file.ptet", NULL, &none, &error));
  FAILS(PTET_BAD_ARGUMENT, "path is NULL", ptet_dataset_open(NULL, NULL, &none, &error));
  FAILS(PTET_BAD_ARGUMENT, "NULL", ptet_dataset_open(path, NULL, NULL, &error));
  CHECK(none == NULL);
  remove(path);
}

static void test_corrupt_memory(const ptet_bytes* bytes) {
  const uint64_t size = ptet_bytes_size(bytes);
  unsigned char* spoilt = malloc(size);
  REQUIRE(spoilt != NULL);
  ptet_dataset* dataset = NULL;
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_dataset_open_memory(NULL, 1, NULL, &dataset, &error));
  FAILS(PTET_CORRUPT_FILE, "short", ptet_dataset_open_memory(NULL, 0, NULL, &dataset, &error));
  FAILS(PTET_BAD_ARGUMENT, "NULL", ptet_dataset_open_memory(spoilt, size, NULL, NULL, &error));
  memcpy(spoilt, ptet_bytes_data(bytes), size);
  FAILS(PTET_CORRUPT_FILE, "", ptet_dataset_open_memory(spoilt, size - 1, NULL, &dataset, &error));
  FAILS(PTET_CORRUPT_FILE, "", ptet_dataset_open_memory(spoilt, 20, NULL, &dataset, &error));
  memset(spoilt, 0, 16);
  ptet_error* refusal = NULL;
  CHECK(ptet_dataset_open_memory(spoilt, size, NULL, &dataset, &refusal) == PTET_CORRUPT_FILE);
  CHECK(ptet_error_offset(refusal) < size);
  ptet_error_free(refusal);
  CHECK(dataset == NULL);

  /* Wherever a byte is spoilt, it is found when the file is opened or when all of it is asked for. */
  for (uint64_t at = 0; at < size; at += 97) {
    memcpy(spoilt, ptet_bytes_data(bytes), size);
    spoilt[at] ^= 0x10;
    ptet_status found = ptet_dataset_open_memory(spoilt, size, NULL, &dataset, NULL);
    CHECK((found == PTET_OK) == (dataset != NULL));
    if (found == PTET_OK) {
      ptet_extraction* extraction = NULL;
      SUCCEEDS(ptet_dataset_extract(dataset, NULL, NULL, NULL, &extraction, &error));
      ptet_extraction_info info = {.struct_size = sizeof info};
      ptet_block_failure failure = {.struct_size = sizeof failure};
      SUCCEEDS(ptet_extraction_get_info(extraction, &info, &error));
      CHECK(info.complete == 0 && info.failures > 0 && info.tets < TETS);
      CHECK(info.limited_by == PTET_LIMITED_BY_UNREADABLE);
      SUCCEEDS(ptet_extraction_get_failure(extraction, 0, &failure, &error));
      CHECK(failure.status == PTET_CORRUPT_FILE && failure.byte_offset <= at && strlen(failure.message) > 0);
      ptet_extraction_free(extraction);
      found = failure.status;
    }
    CHECK(found == PTET_CORRUPT_FILE || found == PTET_LIMIT);
    ptet_dataset_free(dataset);
  }
  free(spoilt);
}

/* A source over memory that counts, can be told to refuse, and notes that it was released. */
struct memory {
  const unsigned char* bytes;
  uint64_t size, reads;
  int32_t answer;
  int released;
};

static int32_t read_memory(void* user, uint64_t offset, uint64_t size, void* into) {
  struct memory* memory = user;
  ++memory->reads;
  CHECK(offset <= memory->size && size <= memory->size - offset && size > 0);
  CHECK(!memory->released);
  if (memory->answer == 0) memcpy(into, memory->bytes + offset, size);
  return memory->answer;
}

static void release_memory(void* user) {
  ++((struct memory*)user)->released;
}

static void test_source(const ptet_bytes* bytes) {
  struct memory memory = {ptet_bytes_data(bytes), ptet_bytes_size(bytes), 0, 0, 0};
  ptet_source source = {sizeof source, memory.size, &memory, read_memory, release_memory};
  ptet_dataset* dataset = NULL;
  SUCCEEDS(ptet_dataset_open_source(&source, NULL, &dataset, &error));
  const uint64_t reads = memory.reads;
  CHECK(reads > 0);
  ptet_extraction* extraction = NULL;
  memory.answer = -5;
  ptet_extraction_info info = {.struct_size = sizeof info};
  ptet_block_failure failure = {.struct_size = sizeof failure};
  SUCCEEDS(ptet_dataset_extract(dataset, NULL, NULL, NULL, &extraction, &error)); /* without what cannot be had */
  SUCCEEDS(ptet_extraction_get_info(extraction, &info, &error));
  CHECK(info.complete == 0 && info.failures > 0 && info.tets < TETS && memory.reads > reads);
  SUCCEEDS(ptet_extraction_get_failure(extraction, 0, &failure, &error));
  CHECK(failure.status == PTET_IO_ERROR && strstr(failure.message, "-5") != NULL);
  FAILS(PTET_BAD_ARGUMENT, "no failure", ptet_extraction_get_failure(extraction, info.failures, &failure, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_extraction_get_failure(extraction, 0, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "extraction is NULL", ptet_extraction_get_failure(NULL, 0, &failure, &error));
  ptet_extraction_free(extraction);
  ptet_session* session = NULL;
  ptet_session_changes changes = {.struct_size = sizeof changes};
  SUCCEEDS(ptet_session_open(dataset, &session, &error));
  FAILS(PTET_BAD_ARGUMENT, "no failure", ptet_session_get_failure(session, 0, &failure, &error));
  SUCCEEDS(ptet_session_update(session, NULL, NULL, NULL, &changes, &error));
  CHECK(changes.complete == 0 && changes.failures > 0);
  SUCCEEDS(ptet_session_get_failure(session, changes.failures - 1, &failure, &error));
  CHECK(failure.status == PTET_IO_ERROR && strstr(failure.message, "-5") != NULL);
  FAILS(PTET_BAD_ARGUMENT, "no failure", ptet_session_get_failure(session, changes.failures, &failure, &error));
  FAILS(PTET_BAD_ARGUMENT, "session is NULL", ptet_session_get_failure(NULL, 0, &failure, &error));
  memory.answer = 0; /* it can be had again */
  SUCCEEDS(ptet_session_update(session, NULL, NULL, NULL, &changes, &error));
  CHECK(changes.complete == 1 && changes.failures == 0 && changes.tets == TETS);
  ptet_session_free(session);
  SUCCEEDS(ptet_dataset_extract(dataset, NULL, NULL, NULL, &extraction, &error));
  CHECK(memory.released == 0);
  ptet_dataset_free(dataset);
  CHECK(memory.released == 1);
  SUCCEEDS(ptet_extraction_get_info(extraction, &info, &error)); /* it outlives its dataset */
  CHECK(info.tets == TETS && info.complete == 1 && info.failures == 0);
  ptet_extraction_free(extraction);

  memory.released = 0;
  memory.answer = 9;
  FAILS(PTET_IO_ERROR, "9", ptet_dataset_open_source(&source, NULL, &dataset, &error));
  CHECK(dataset == NULL && memory.released == 1);
  memory.answer = 0;
  memory.released = 0;
  source.release = NULL;
  SUCCEEDS(ptet_dataset_open_source(&source, NULL, &dataset, &error));
  ptet_dataset_free(dataset);
  CHECK(memory.released == 0);
  ptet_open_options options = {.struct_size = sizeof options, .background = 1};
  SUCCEEDS(ptet_dataset_open_source(&source, &options, &dataset, &error));
  for (int tries = 0; tries < 100; ++tries) {
    SUCCEEDS(ptet_dataset_extract(dataset, NULL, NULL, NULL, &extraction, &error));
    SUCCEEDS(ptet_extraction_get_info(extraction, &info, &error));
    ptet_extraction_free(extraction);
    if (info.complete) break;
    CHECK(info.limited_by == PTET_LIMITED_BY_LOADING);
    SUCCEEDS(ptet_dataset_wait_until_loaded(dataset, NULL, NULL, &error));
  }
  CHECK(info.complete == 1 && info.tets == TETS && info.read_requests > 0);
  ptet_dataset_free(dataset);
  FAILS(PTET_BAD_ARGUMENT, "dataset is NULL", ptet_dataset_wait_until_loaded(NULL, NULL, NULL, &error));
  options.max_vertices = 10;
  FAILS(PTET_LIMIT, "", ptet_dataset_open_source(&source, &options, &dataset, &error));
  options.struct_size = 3;
  FAILS(PTET_BAD_ARGUMENT, "struct_size", ptet_dataset_open_source(&source, &options, &dataset, &error));
  source.read = NULL;
  FAILS(PTET_BAD_ARGUMENT, "read", ptet_dataset_open_source(&source, NULL, &dataset, &error));
  source.struct_size = 8;
  FAILS(PTET_BAD_ARGUMENT, "struct_size", ptet_dataset_open_source(&source, NULL, &dataset, &error));
  FAILS(PTET_BAD_ARGUMENT, "source is NULL", ptet_dataset_open_source(NULL, NULL, &dataset, &error));
  FAILS(PTET_BAD_ARGUMENT, "NULL", ptet_dataset_open_source(&source, NULL, NULL, &error));
}

static void test_dataset(const ptet_dataset* dataset) {
  ptet_dataset_info info = {.struct_size = sizeof info};
  SUCCEEDS(ptet_dataset_get_info(dataset, &info, &error));
  CHECK(info.struct_size == sizeof info);
  CHECK(info.vertices == POINTS && info.tets == TETS && info.fields == 3);
  CHECK(info.base_vertices + info.records == POINTS && info.base_tets < TETS && info.blocks > 0);
  CHECK(info.position_type == PTET_FLOAT32);
  for (int i = 0; i < 3; ++i)
    CHECK(info.box_min[i] == 0 && info.box_max[i] == CUBES);
  CHECK(fabs(info.diagonal - sqrt(3.0) * CUBES) < 1e-12 && info.max_domain_error >= 0);

  /* Who knows more members than the library gets 0 for them; who says nonsense is told. */
  struct {
    ptet_dataset_info known;
    uint64_t later[2];
  } longer;
  memset(&longer, 0xAB, sizeof longer);
  longer.known.struct_size = sizeof longer;
  SUCCEEDS(ptet_dataset_get_info(dataset, &longer.known, &error));
  CHECK(longer.known.struct_size == sizeof longer && longer.known.vertices == POINTS);
  CHECK(longer.known.max_domain_error == info.max_domain_error && longer.later[0] == 0 && longer.later[1] == 0);
  info.struct_size = 16;
  FAILS(PTET_BAD_ARGUMENT, "struct_size", ptet_dataset_get_info(dataset, &info, &error));
  info.struct_size = UINT64_MAX;
  FAILS(PTET_BAD_ARGUMENT, "struct_size", ptet_dataset_get_info(dataset, &info, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_dataset_get_info(dataset, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "dataset is NULL", ptet_dataset_get_info(NULL, &info, &error));

  ptet_field_info field = {.struct_size = sizeof field};
  SUCCEEDS(ptet_dataset_get_field(dataset, 1, &field, &error));
  CHECK(strcmp(field.name, "flow") == 0 && field.type == PTET_FLOAT64 && field.components == 3);
  CHECK(field.governing == 1 && field.range > 0 && field.max_error > 0 && field.max_rms > 0);
  SUCCEEDS(ptet_dataset_get_field(dataset, 2, &field, &error));
  CHECK(strcmp(field.name, "marker") == 0 && field.type == PTET_UINT8 && field.governing == 0);
  CHECK(isnan(field.max_error) && isnan(field.max_rms));
  FAILS(PTET_BAD_ARGUMENT, "no field 3", ptet_dataset_get_field(dataset, 3, &field, &error));
  FAILS(PTET_BAD_ARGUMENT, "dataset is NULL", ptet_dataset_get_field(NULL, 0, &field, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_dataset_get_field(dataset, 0, NULL, &error));
  field.struct_size = 1;
  FAILS(PTET_BAD_ARGUMENT, "struct_size", ptet_dataset_get_field(dataset, 0, &field, &error));
  CHECK(ptet_dataset_find_field(dataset, "pressure") == 0 && ptet_dataset_find_field(dataset, "marker") == 2);
  CHECK(ptet_dataset_find_field(dataset, "press") == -1 && ptet_dataset_find_field(dataset, NULL) == -1);
  CHECK(ptet_dataset_find_field(NULL, "pressure") == -1);
  CHECK(strstr(ptet_dataset_provenance(dataset), "tool_version") != NULL);
  CHECK(strcmp(ptet_dataset_provenance(NULL), "") == 0);
  ptet_dataset_free(NULL);
}

static void test_requests_refused(const ptet_dataset* dataset) {
  ptet_request* request = ptet_request_new();
  REQUIRE(request != NULL);
  ptet_extraction* extraction = NULL;
  const double a[3] = {1, 1, 1}, b[3] = {2, 2, 2};
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_clear(NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_add_field_error(NULL, "", 1, 0, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_set_domain_error(NULL, 1, 0, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_set_max_tets(NULL, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_set_max_vertices(NULL, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_set_max_milliseconds(NULL, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_add_focus_box(NULL, a, b, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_add_focus_sphere(NULL, a, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_set_focus_error(NULL, 1, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_set_focus_falloff(NULL, 1, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_set_region_error(NULL, 0, 1, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_set_region_falloff(NULL, 0, 1, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "no focus region 0", ptet_request_set_region_error(request, 0, 1, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "no focus region 0", ptet_request_set_region_falloff(request, 0, 1, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_add_focus_oriented_box(NULL, a, b, &error));
  FAILS(PTET_BAD_ARGUMENT, "centre is NULL", ptet_request_add_focus_oriented_box(request, NULL, b, &error));
  FAILS(PTET_BAD_ARGUMENT, "half axes is NULL", ptet_request_add_focus_oriented_box(request, a, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_add_focus_half_space(NULL, a, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "normal is NULL", ptet_request_add_focus_half_space(request, NULL, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_add_values(NULL, "pressure", 1, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_request_add_values(request, NULL, 1, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_set_max_bytes(NULL, 1, &error));
  ptet_view view = {0};
  FAILS(PTET_BAD_ARGUMENT, "struct_size", ptet_request_set_view(request, &view, &error));
  view.struct_size = sizeof view;
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_set_view(NULL, &view, &error));
  FAILS(PTET_BAD_ARGUMENT, "view is NULL", ptet_request_set_view(request, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_set_origins(NULL, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_request_add_focus_box(request, NULL, b, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_request_add_focus_box(request, a, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_request_add_focus_sphere(request, NULL, 1, &error));

#define REFUSED(part, call)                                                                                            \
  do {                                                                                                                 \
    SUCCEEDS(ptet_request_clear(request, &error));                                                                     \
    SUCCEEDS(call);                                                                                                    \
    FAILS(PTET_BAD_ARGUMENT, part, ptet_dataset_extract(dataset, request, NULL, NULL, &extraction, &error));           \
    CHECK(extraction == NULL);                                                                                         \
  } while (0)
  REFUSED("no field 'density'", ptet_request_add_field_error(request, "density", 1, 0, &error));
  REFUSED("did not govern", ptet_request_add_field_error(request, "marker", 1, 0, &error));
  REFUSED("not negative", ptet_request_add_field_error(request, NULL, -1, 1, &error));
  REFUSED("domain", ptet_request_set_domain_error(request, INFINITY, 0, &error));
  REFUSED("box is empty", ptet_request_add_focus_box(request, b, a, &error));
  REFUSED("radius", ptet_request_add_focus_sphere(request, a, NAN, &error));
  REFUSED("", ptet_request_add_values(request, "marker", 1, 1, &error));
  REFUSED("", ptet_request_set_view(request, &view, &error)); /* without a direction */
#undef REFUSED
  SUCCEEDS(ptet_request_clear(request, &error));
  FAILS(PTET_BAD_ARGUMENT, "NULL", ptet_dataset_extract(dataset, request, NULL, NULL, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "dataset is NULL", ptet_dataset_extract(NULL, request, NULL, NULL, &extraction, &error));
  struct counter counter = {0, 1};
  SUCCEEDS(ptet_request_set_max_tets(request, TETS / 2, &error));
  FAILS(PTET_CANCELLED, "", ptet_dataset_extract(dataset, request, count_progress, &counter, &extraction, &error));
  CHECK(extraction == NULL);
  ptet_request_free(request);
  ptet_request_free(NULL);
}

/* Volumes of positive tets that add up to the block's: its mesh is whole. */
static double volume_of(const ptet_extraction* extraction) {
  ptet_array positions = {.struct_size = sizeof positions};
  ptet_extraction_info info = {.struct_size = sizeof info};
  SUCCEEDS(ptet_extraction_get_positions(extraction, &positions, &error));
  SUCCEEDS(ptet_extraction_get_info(extraction, &info, &error));
  const float* at = positions.data;
  const uint32_t* tets = ptet_extraction_tets(extraction);
  double volume = 0;
  for (uint64_t t = 0; t < info.tets; ++t) {
    double edge[3][3];
    for (int e = 0; e < 3; ++e)
      for (int i = 0; i < 3; ++i)
        edge[e][i] = (double)at[3 * tets[4 * t + (uint64_t)e + 1] + (uint32_t)i] - at[3 * tets[4 * t] + (uint32_t)i];
    const double six = edge[0][0] * (edge[1][1] * edge[2][2] - edge[1][2] * edge[2][1]) -
                       edge[0][1] * (edge[1][0] * edge[2][2] - edge[1][2] * edge[2][0]) +
                       edge[0][2] * (edge[1][0] * edge[2][1] - edge[1][1] * edge[2][0]);
    CHECK(six > 0);
    volume += six / 6;
  }
  return volume;
}

static void test_whole_extraction(const ptet_dataset* dataset) {
  ptet_extraction* whole = NULL;
  SUCCEEDS(ptet_dataset_extract(dataset, NULL, NULL, NULL, &whole, &error));
  ptet_extraction_info info = {.struct_size = sizeof info};
  SUCCEEDS(ptet_extraction_get_info(whole, &info, &error));
  CHECK(info.vertices == POINTS && info.tets == TETS && info.boundary_faces == 12 * CUBES * CUBES && info.fields == 3);
  CHECK(info.limited_by == PTET_LIMITED_BY_NOTHING && info.domain_error == 0);
  CHECK(info.bytes_read > 0 && info.seconds >= 0);
  CHECK(fabs(volume_of(whole) - CUBES * CUBES * CUBES) < 1e-9);
  CHECK(ptet_extraction_made_by(whole) == NULL);
  for (uint32_t f = 0; f < 2; ++f)
    CHECK(ptet_extraction_field_error(whole, f) == 0 && ptet_extraction_rms_error(whole, f) == 0);
  CHECK(isnan(ptet_extraction_field_error(whole, 2)) && isnan(ptet_extraction_rms_error(whole, 2)));
  CHECK(isnan(ptet_extraction_field_error(whole, 3)) && isnan(ptet_extraction_rms_error(whole, 3)));

  /* The arrays are those that went in, in another order: the marker and the position tell which vertex is which. */
  ptet_array positions = {.struct_size = sizeof positions}, values = {.struct_size = sizeof values};
  SUCCEEDS(ptet_extraction_get_positions(whole, &positions, &error));
  CHECK(strcmp(positions.name, "") == 0 && positions.type == PTET_FLOAT32 && positions.components == 3);
  CHECK(positions.rows == POINTS);
  const float* at = positions.data;
  const uint32_t* in_file = ptet_extraction_vertices_in_file(whole);
  for (int f = 0; f < 3; ++f) {
    SUCCEEDS(ptet_extraction_get_field(whole, (uint32_t)f, &values, &error));
    CHECK(values.rows == POINTS);
    for (uint32_t v = 0; v < POINTS; ++v) {
      const uint32_t cell[3] = {(uint32_t)at[3 * v], (uint32_t)at[3 * v + 1], (uint32_t)at[3 * v + 2]};
      const uint32_t p = point_at(cell);
      CHECK(in_file[v] == v);
      if (f == 0) CHECK(memcmp((const float*)values.data + v, pressure + p, sizeof(float)) == 0);
      if (f == 1) CHECK(memcmp((const double*)values.data + 3 * v, flow + 3 * p, 3 * sizeof(double)) == 0);
      if (f == 2) CHECK(((const uint8_t*)values.data)[v] == marker[p]);
    }
  }
  FAILS(PTET_BAD_ARGUMENT, "no field 3", ptet_extraction_get_field(whole, 3, &values, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_extraction_get_field(whole, 0, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "extraction is NULL", ptet_extraction_get_field(NULL, 0, &values, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_extraction_get_positions(whole, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "extraction is NULL", ptet_extraction_get_positions(NULL, &values, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_extraction_get_info(whole, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "extraction is NULL", ptet_extraction_get_info(NULL, &info, &error));
  values.struct_size = 0;
  FAILS(PTET_BAD_ARGUMENT, "struct_size", ptet_extraction_get_positions(whole, &values, &error));
  info.struct_size = 0;
  FAILS(PTET_BAD_ARGUMENT, "struct_size", ptet_extraction_get_info(whole, &info, &error));

  /* Every boundary face looks outward: seen from the middle of the block. */
  const uint32_t* faces = ptet_extraction_boundary_faces(whole);
  for (uint64_t f = 0; f < 12 * CUBES * CUBES; ++f) {
    double p[3][3];
    for (int c = 0; c < 3; ++c)
      for (int i = 0; i < 3; ++i)
        p[c][i] = at[3 * faces[3 * f + (uint64_t)c] + (uint32_t)i] - 0.5 * CUBES;
    CHECK(p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) - p[0][1] * (p[1][0] * p[2][2] - p[1][2] * p[2][0]) +
              p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]) >
          0);
  }
  CHECK(ptet_extraction_tets(NULL) == NULL && ptet_extraction_boundary_faces(NULL) == NULL);
  CHECK(ptet_extraction_vertices_in_file(NULL) == NULL && ptet_extraction_made_by(NULL) == NULL);
  CHECK(isnan(ptet_extraction_field_error(NULL, 0)) && isnan(ptet_extraction_rms_error(NULL, 0)));
  CHECK(isnan(ptet_extraction_covered(NULL)));
  ptet_extraction_free(whole);
  ptet_extraction_free(NULL);
}

/* Points that stand twice, one of each in no tet. */
static void test_welding(void) {
  float twice[6 * POINTS];
  memcpy(twice, xyz, sizeof xyz);
  memcpy(twice + 3 * POINTS, xyz, sizeof xyz);
  for (int welds = 0; welds < 2; ++welds) {
    ptet_builder* builder = ptet_builder_new();
    SUCCEEDS(ptet_builder_set_points(builder, PTET_FLOAT32, 2 * POINTS, twice, &error));
    SUCCEEDS(ptet_builder_set_tets(builder, TETS, corners, &error));
    SUCCEEDS(ptet_builder_set_weld(builder, welds, &error));
    ptet_bytes* bytes = NULL;
    ptet_build_report report = {.struct_size = sizeof report};
    SUCCEEDS(ptet_builder_build_memory(builder, NULL, NULL, &bytes, &report, &error));
    CHECK(report.input_vertices == (welds ? 1 : 2) * POINTS);
    ptet_bytes_free(bytes);
    ptet_builder_free(builder);
  }

  /* Every other tet with points of its own, which are not quite those of the others. */
  uint32_t apart[4 * TETS];
  for (int i = 0; i < 4 * TETS; ++i)
    apart[i] = corners[i] + (i / 4 % 2 == 0 ? 0 : POINTS);
  for (int i = 0; i < 3 * POINTS; ++i)
    twice[3 * POINTS + i] = xyz[i] + 1e-6F;
  ptet_builder* builder = ptet_builder_new();
  SUCCEEDS(ptet_builder_set_points(builder, PTET_FLOAT32, 2 * POINTS, twice, &error));
  SUCCEEDS(ptet_builder_set_tets(builder, TETS, apart, &error));
  uint64_t left[3] = {0};
  for (int i = 0; i < 3; ++i) {
    SUCCEEDS(ptet_builder_set_weld_within(builder, i == 1 ? 5e-6 : i == 2 ? 1e-5 : 0, i == 2, &error));
    ptet_bytes* bytes = NULL;
    ptet_build_report report = {.struct_size = sizeof report};
    SUCCEEDS(ptet_builder_build_memory(builder, NULL, NULL, &bytes, &report, &error));
    left[i] = report.input_vertices;
    ptet_bytes_free(bytes);
  }
  CHECK(left[0] == 2 * POINTS && left[1] < left[0] && left[2] == left[1]);
  ptet_bytes* bytes = NULL;
  SUCCEEDS(ptet_builder_set_weld_within(builder, 0.01, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "a thousandth of the diagonal",
        ptet_builder_build_memory(builder, NULL, NULL, &bytes, NULL, &error));
  SUCCEEDS(ptet_builder_set_weld_within(builder, -1, 0, &error));
  FAILS(PTET_BAD_ARGUMENT, "welded", ptet_builder_build_memory(builder, NULL, NULL, &bytes, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "builder is NULL", ptet_builder_set_weld_within(NULL, 0, 0, &error));
  ptet_builder_free(builder);
}

/* What was given comes back as it stood, where that is kept. */
static void test_input_order(const ptet_dataset* without) {
  ptet_request* request = ptet_request_new();
  ptet_dataset* dataset = NULL;
  ptet_extraction* extraction = NULL;
  SUCCEEDS(ptet_request_set_input_order(request, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "request is NULL", ptet_request_set_input_order(NULL, 1, &error));
  FAILS(PTET_BAD_ARGUMENT, "order", ptet_dataset_extract(without, request, NULL, NULL, &extraction, &error));
  ptet_builder* builder = quick_builder();
  SUCCEEDS(ptet_builder_set_keep_order(builder, 1, &error));
  ptet_bytes* bytes = build(builder);
  ptet_builder_free(builder);
  SUCCEEDS(ptet_dataset_open_memory(ptet_bytes_data(bytes), ptet_bytes_size(bytes), NULL, &dataset, &error));
  ptet_bytes_free(bytes);
  ptet_dataset_info info = {.struct_size = sizeof info};
  SUCCEEDS(ptet_dataset_get_info(without, &info, &error));
  CHECK(info.has_input_order == 0);
  SUCCEEDS(ptet_dataset_get_info(dataset, &info, &error));
  CHECK(info.has_input_order == 1);
  CHECK(info.errors_are_bounds == 1);
  CHECK(info.overlaps_itself == 0 && info.reserved == 0);
  CHECK(info.memory_for_all > info.file_bytes);
  SUCCEEDS(ptet_dataset_extract(dataset, request, NULL, NULL, &extraction, &error));
  ptet_array positions = {.struct_size = sizeof positions};
  SUCCEEDS(ptet_extraction_get_positions(extraction, &positions, &error));
  CHECK(memcmp(positions.data, xyz, sizeof xyz) == 0);
  CHECK(memcmp(ptet_extraction_tets(extraction), corners, sizeof corners) == 0);
  const uint32_t* ids = ptet_extraction_input_vertices(extraction);
  REQUIRE(ids != NULL);
  for (uint32_t p = 0; p < POINTS; ++p)
    CHECK(ids[p] == p);
  ptet_extraction_free(extraction);
  SUCCEEDS(ptet_dataset_extract(dataset, NULL, NULL, NULL, &extraction, &error));
  CHECK(ptet_extraction_input_vertices(extraction) == NULL && ptet_extraction_input_vertices(NULL) == NULL);
  ptet_extraction_free(extraction);
  ptet_dataset_free(dataset);
  ptet_request_free(request);
}

/* Each kind of condition does what it says. */
static void test_requests(const ptet_dataset* dataset) {
  ptet_request* request = ptet_request_new();
  REQUIRE(request != NULL);
  ptet_extraction* extraction = NULL;
  ptet_extraction_info info = {.struct_size = sizeof info};
#define EXTRACT()                                                                                                      \
  do {                                                                                                                 \
    ptet_extraction_free(extraction);                                                                                  \
    struct counter counter = {0, 0};                                                                                   \
    SUCCEEDS(ptet_dataset_extract(dataset, request, count_progress, &counter, &extraction, &error));                   \
    REQUIRE(extraction != NULL);                                                                                       \
    SUCCEEDS(ptet_extraction_get_info(extraction, &info, &error));                                                     \
    CHECK(fabs(volume_of(extraction) - CUBES * CUBES * CUBES) < 30);                                                   \
  } while (0)

  ptet_field_info field = {.struct_size = sizeof field};
  SUCCEEDS(ptet_dataset_get_field(dataset, 0, &field, &error));
  SUCCEEDS(ptet_request_add_field_error(request, "pressure", 0.2, 1, &error));
  SUCCEEDS(ptet_request_set_domain_error(request, 0.5, 0, &error));
  EXTRACT();
  const uint64_t tets_at_fifth = info.tets;
  CHECK(info.limited_by == PTET_LIMITED_BY_ERROR && info.tets < TETS && info.domain_error <= 0.5);
  CHECK(ptet_extraction_field_error(extraction, 0) > 0);
  CHECK(ptet_extraction_field_error(extraction, 0) <= 0.2 * field.range);
  CHECK(ptet_extraction_rms_error(extraction, 0) > 0);
  CHECK(ptet_extraction_rms_error(extraction, 0) < ptet_extraction_field_error(extraction, 0));
  CHECK(ptet_extraction_covered(extraction) > 0.5 && ptet_extraction_covered(extraction) <= 1);
  SUCCEEDS(ptet_request_add_field_error(request, NULL, 0.02 * field.range, 0, &error)); /* of both, the tighter holds */
  EXTRACT();
  CHECK(info.tets > tets_at_fifth);
  CHECK(ptet_extraction_field_error(extraction, 0) <= 0.02 * field.range);
  CHECK(ptet_extraction_field_error(extraction, 1) <= 0.02 * field.range);

  SUCCEEDS(ptet_request_clear(request, &error));
  SUCCEEDS(ptet_request_set_max_tets(request, TETS / 2, &error));
  EXTRACT();
  CHECK(info.limited_by == PTET_LIMITED_BY_BUDGET && info.tets <= TETS / 2 && info.tets > TETS / 3);
  SUCCEEDS(ptet_request_set_max_vertices(request, POINTS / 4, &error)); /* now both hold */
  EXTRACT();
  CHECK(info.vertices <= POINTS / 4 && info.vertices > POINTS / 6);

  /* In the focus every tet is an original one, which no record made. */
  const double low[3] = {0, 0, 0}, high[3] = {2, 2, 2}, centre[3] = {5, 5, 5};
  SUCCEEDS(ptet_request_clear(request, &error));
  SUCCEEDS(ptet_request_add_focus_box(request, low, high, &error));
  EXTRACT();
  const uint64_t tets_of_box = info.tets;
  CHECK(info.limited_by == PTET_LIMITED_BY_FOCUS);
  CHECK(ptet_extraction_part_field_error(extraction, PTET_PART_FOCUS, 0, 0) == 0);
  CHECK(ptet_extraction_part_domain_error(extraction, PTET_PART_FOCUS, 0) == 0);
  CHECK(ptet_extraction_field_error(extraction, 0) > 0);
  CHECK(isnan(ptet_extraction_part_field_error(extraction, PTET_PART_FOCUS, 1, 0)));
  CHECK(isnan(ptet_extraction_part_field_error(extraction, PTET_PART_FOCUS, 0, 2))); /* does not govern */
  CHECK(isnan(ptet_extraction_part_domain_error(extraction, PTET_PART_VIEW, 0)));
  CHECK(isnan(ptet_extraction_part_domain_error(NULL, PTET_PART_FOCUS, 0)));
  CHECK(ptet_extraction_pixels_in_view(extraction) == 0);
  CHECK(ptet_dataset_bytes_read(dataset) == info.bytes_read && ptet_dataset_bytes_read(NULL) == 0);
  const double beside[3] = {1e3, 1e3, 1e3};
  SUCCEEDS(ptet_request_add_focus_sphere(request, beside, 0.9, &error));
  SUCCEEDS(ptet_request_add_values(request, "pressure", 1e30, 2e30, &error));
  EXTRACT();
  CHECK(!ptet_extraction_is_unmet(extraction, request, PTET_PART_FOCUS, 0));
  CHECK(ptet_extraction_is_unmet(extraction, request, PTET_PART_FOCUS, 1));
  CHECK(!ptet_extraction_is_unmet(extraction, request, PTET_PART_FOCUS, 2));
  CHECK(ptet_extraction_is_unmet(extraction, request, PTET_PART_VALUES, 0));
  CHECK(!ptet_extraction_is_unmet(extraction, request, PTET_PART_VIEW, 0));
  {
    ptet_view view = {0};
    view.struct_size = sizeof view;
    view.eye[2] = 1e4;
    view.direction[2] = 1;
    view.up[1] = 1;
    view.vertical_angle = 0.5;
    view.width = 640;
    view.height = 480;
    view.max_pixels = 1;
    SUCCEEDS(ptet_request_set_view(request, &view, &error));
    CHECK(ptet_extraction_is_unmet(extraction, request, PTET_PART_VIEW, 0));
    CHECK(!ptet_extraction_is_unmet(extraction, request, PTET_PART_VIEW, 1));
    view.direction[2] = -1;
    SUCCEEDS(ptet_request_set_view(request, &view, &error));
    CHECK(!ptet_extraction_is_unmet(extraction, request, PTET_PART_VIEW, 0));
  }
  CHECK(!ptet_extraction_is_unmet(NULL, request, PTET_PART_FOCUS, 1));
  CHECK(!ptet_extraction_is_unmet(extraction, NULL, PTET_PART_FOCUS, 1));
  SUCCEEDS(ptet_request_clear(request, &error));
  SUCCEEDS(ptet_request_add_focus_box(request, low, high, &error));
  SUCCEEDS(ptet_request_add_focus_sphere(request, centre, 0.9, &error));
  SUCCEEDS(ptet_request_set_origins(request, 1, &error));
  EXTRACT();
  const uint64_t tets_of_both = info.tets;
  CHECK(tets_of_both > tets_of_box && tets_of_both < TETS);
  const uint32_t* made_by = ptet_extraction_made_by(extraction);
  const uint32_t* tets = ptet_extraction_tets(extraction);
  ptet_array positions = {.struct_size = sizeof positions};
  SUCCEEDS(ptet_extraction_get_positions(extraction, &positions, &error));
  const float* at = positions.data;
  uint64_t original = 0, inside = 0;
  REQUIRE(made_by != NULL);
  for (uint64_t t = 0; t < info.tets; ++t) {
    double nearest[3] = {CUBES, CUBES, CUBES};
    for (uint64_t c = 0; c < 4; ++c)
      for (uint32_t i = 0; i < 3; ++i)
        if (at[3 * tets[4 * t + c] + i] < nearest[i]) nearest[i] = at[3 * tets[4 * t + c] + i];
    const int starts_in_box = nearest[0] < 2 && nearest[1] < 2 && nearest[2] < 2;
    original += made_by[t] == UINT32_MAX;
    inside += starts_in_box && made_by[t] == UINT32_MAX;
  }
  CHECK(inside >= 6 * 2 * 2 * 2 && original < info.tets && original < TETS);
  SUCCEEDS(ptet_request_set_focus_error(request, 0.05, 1, &error));
  EXTRACT();
  CHECK(info.tets < tets_of_both);
  for (uint32_t region = 0; region < 2; ++region)
    CHECK(ptet_extraction_part_field_error(extraction, PTET_PART_FOCUS, region, 0) <= 0.05 * field.range);

  SUCCEEDS(ptet_request_clear(request, &error));
  SUCCEEDS(ptet_request_add_field_error(request, "pressure", 0.02, 1, &error));
  SUCCEEDS(ptet_request_add_values(request, "pressure", 0.5, 0.5, &error));
  EXTRACT();
  CHECK(ptet_extraction_part_field_error(extraction, PTET_PART_VALUES, 0, 0) <= 0.02 * field.range);
  CHECK(ptet_extraction_part_field_error(extraction, PTET_PART_VALUES, 0, 0) > 0);
#undef EXTRACT
  ptet_extraction_free(extraction);
  ptet_request_free(request);
}

/* The mesh by slots has the tets that are used, whose corners are used vertices; what changed is what differs from the
 * copy that was kept of it; and as a whole it is that of an extraction. */
static void check_session(const ptet_dataset* dataset, const ptet_session* session, const ptet_request* request,
                          const ptet_session_changes* changes, uint32_t* copy) {
  uint64_t slots = 0, face_slots = 0, vertex_slots = 0, used = 0, used_faces = 0, used_vertices = 0, differ = 0;
  const uint32_t* tets = ptet_session_tets(session, &slots);
  const uint32_t* faces = ptet_session_boundary_faces(session, &face_slots);
  const uint32_t* in_file = ptet_session_vertices_in_file(session, &vertex_slots);
  REQUIRE(slots <= TETS + 1000);
  for (uint64_t t = 0; t < slots; ++t) {
    if (tets[4 * t] == UINT32_MAX) continue;
    ++used;
    for (uint64_t c = 0; c < 4; ++c)
      CHECK(tets[4 * t + c] < vertex_slots && in_file[tets[4 * t + c]] != UINT32_MAX);
  }
  for (uint64_t f = 0; f < face_slots; ++f)
    used_faces += faces[3 * f] != UINT32_MAX;
  for (uint64_t v = 0; v < vertex_slots; ++v)
    used_vertices += in_file[v] != UINT32_MAX;
  CHECK(used == changes->tets && used_faces == changes->boundary_faces && used_vertices == changes->vertices);
  for (uint64_t i = 0; i < changes->changed_tet_count; ++i)
    memcpy(copy + 4 * changes->changed_tets[i], tets + 4 * changes->changed_tets[i], 4 * sizeof *tets);
  for (uint64_t i = 0; i < 4 * slots; ++i)
    differ += copy[i] != tets[i];
  CHECK(differ == 0);
  for (uint64_t i = 0; i < changes->changed_face_count; ++i)
    CHECK(changes->changed_faces[i] < face_slots);
  for (uint64_t i = 0; i < changes->changed_vertex_count; ++i)
    CHECK(changes->changed_vertices[i] < vertex_slots);

  ptet_extraction *own = NULL, *fresh = NULL;
  SUCCEEDS(ptet_session_extract(session, &own, &error));
  SUCCEEDS(ptet_dataset_extract(dataset, request, NULL, NULL, &fresh, &error));
  ptet_extraction_info info = {.struct_size = sizeof info};
  SUCCEEDS(ptet_extraction_get_info(fresh, &info, &error));
  REQUIRE(info.tets == changes->tets && info.vertices == changes->vertices);
  CHECK(info.boundary_faces == changes->boundary_faces && info.domain_error == changes->domain_error);
  CHECK(info.limited_by == changes->limited_by);
  CHECK(memcmp(ptet_extraction_tets(own), ptet_extraction_tets(fresh), info.tets * 16) == 0);
  CHECK(memcmp(ptet_extraction_vertices_in_file(own), ptet_extraction_vertices_in_file(fresh), info.vertices * 4) == 0);
  for (uint32_t f = 0; f < 2; ++f) {
    CHECK(ptet_session_field_error(session, f) == ptet_extraction_field_error(fresh, f));
    CHECK(ptet_session_rms_error(session, f) == ptet_extraction_rms_error(fresh, f));
    CHECK(ptet_extraction_field_error(own, f) == ptet_extraction_field_error(fresh, f));
  }
  CHECK(ptet_session_covered(session) == ptet_extraction_covered(fresh));
  CHECK(isnan(ptet_session_field_error(session, 2)));

  /* The slots' tets were made by the records that made the extraction's. */
  uint64_t maker_slots = 0, sum = 0, wanted_sum = 0;
  const uint32_t* made_by = ptet_session_made_by(session, &maker_slots);
  const uint32_t* wanted = ptet_extraction_made_by(fresh);
  CHECK((made_by == NULL) == (wanted == NULL) && maker_slots == (made_by == NULL ? 0 : slots));
  if (made_by != NULL && wanted != NULL) {
    double* values = malloc(slots * sizeof *values);
    REQUIRE(values != NULL);
    for (uint64_t t = 0; t < slots; ++t) {
      if (tets[4 * t] == UINT32_MAX) CHECK(made_by[t] == UINT32_MAX);
      if (tets[4 * t] != UINT32_MAX) sum += made_by[t];
    }
    for (uint64_t t = 0; t < info.tets; ++t)
      wanted_sum += wanted[t];
    CHECK(sum == wanted_sum);
    for (uint32_t f = 0; f < 2; ++f) {
      double most = 0;
      SUCCEEDS(ptet_dataset_get_origin_values(dataset, made_by, slots, PTET_ORIGIN_FIELD_ERROR, f, values, &error));
      for (uint64_t t = 0; t < slots; ++t)
        most = values[t] > most ? values[t] : most;
      CHECK(most == ptet_session_field_error(session, f));
    }
    SUCCEEDS(ptet_dataset_get_origin_values(dataset, made_by, slots, PTET_ORIGIN_LEVEL, 99, values, &error));
    for (uint64_t t = 0; t < slots; ++t)
      CHECK((values[t] == 0) == (made_by[t] == UINT32_MAX));
    SUCCEEDS(ptet_dataset_get_origin_values(dataset, made_by, slots, PTET_ORIGIN_DOMAIN_ERROR, 0, values, &error));
    SUCCEEDS(ptet_dataset_get_origin_values(dataset, made_by, slots, PTET_ORIGIN_GENERATION, 0, values, &error));
    free(values);
  }

  /* The rows of the slots are those of the vertices in them: vertices of the file ascend in an extraction. */
  ptet_array by_slot = {.struct_size = sizeof by_slot}, by_id = {.struct_size = sizeof by_id};
  SUCCEEDS(ptet_session_get_positions(session, &by_slot, &error));
  SUCCEEDS(ptet_extraction_get_positions(fresh, &by_id, &error));
  CHECK(by_slot.rows == vertex_slots && by_slot.type == PTET_FLOAT32);
  const uint32_t* ids = ptet_extraction_vertices_in_file(fresh);
  ptet_array pressure_by_slot = {.struct_size = sizeof pressure_by_slot}, pressure_by_id = pressure_by_slot;
  SUCCEEDS(ptet_session_get_field(session, 0, &pressure_by_slot, &error));
  SUCCEEDS(ptet_extraction_get_field(fresh, 0, &pressure_by_id, &error));
  for (uint64_t v = 0; v < vertex_slots; ++v) {
    if (in_file[v] == UINT32_MAX) continue;
    uint64_t row = 0;
    while (row < info.vertices && ids[row] != in_file[v])
      ++row;
    REQUIRE(row < info.vertices);
    CHECK(memcmp((const float*)by_slot.data + 3 * v, (const float*)by_id.data + 3 * row, 3 * sizeof(float)) == 0);
    CHECK(memcmp((const float*)pressure_by_slot.data + v, (const float*)pressure_by_id.data + row, sizeof(float)) == 0);
  }
  ptet_extraction_free(own);
  ptet_extraction_free(fresh);
}

static void test_sessions(const ptet_dataset* dataset) {
  ptet_session* session = NULL;
  FAILS(PTET_BAD_ARGUMENT, "dataset is NULL", ptet_session_open(NULL, &session, &error));
  FAILS(PTET_BAD_ARGUMENT, "NULL", ptet_session_open(dataset, NULL, &error));
  SUCCEEDS(ptet_session_open(dataset, &session, &error));
  REQUIRE(session != NULL);
  CHECK(isnan(ptet_session_field_error(session, 0)) && isnan(ptet_session_rms_error(session, 0)));
  CHECK(isnan(ptet_session_covered(session)));
  ptet_request* request = ptet_request_new();
  ptet_session_changes changes = {.struct_size = sizeof changes};
  uint32_t* copy = malloc((TETS + 1000) * 4 * sizeof *copy);
  REQUIRE(request != NULL && copy != NULL);
  memset(copy, 0xFF, (TETS + 1000) * 4 * sizeof *copy);
  /* A sphere that moves through a coarse mesh, then budgets, the coarsest mesh, and the original. */
  for (int step = 0; step < 8; ++step) {
    const double centre[3] = {0.8 * step, 0.5 * step, 3};
    SUCCEEDS(ptet_request_clear(request, &error));
    SUCCEEDS(ptet_request_set_max_milliseconds(request, 1e6, &error));
    if (step < 5) SUCCEEDS(ptet_request_add_field_error(request, NULL, 0.2, 1, &error));
    if (step < 5) SUCCEEDS(ptet_request_add_focus_sphere(request, centre, 1, &error));
    if (step == 5) SUCCEEDS(ptet_request_set_max_tets(request, TETS / 2, &error));
    if (step == 6) SUCCEEDS(ptet_request_set_max_tets(request, 0, &error));
    SUCCEEDS(ptet_request_set_origins(request, step > 1 && step < 6, &error));
    const ptet_request* asked = step == 7 ? NULL : request;
    SUCCEEDS(ptet_session_update(session, asked, NULL, NULL, &changes, &error));
    CHECK(changes.struct_size == sizeof changes && changes.complete == 1 && changes.seconds >= 0);
    CHECK(changes.splits > 0 || changes.collapses > 0 || step == 0);
    CHECK(changes.vertices_added == (step == 0 ? changes.vertices : changes.splits));
    CHECK(changes.tets_added >= changes.splits / 2);
    CHECK(changes.vertices_removed == changes.collapses && changes.tets_removed >= changes.collapses / 2);
    check_session(dataset, session, asked, &changes, copy);
  }
  CHECK(changes.tets == TETS);
  SUCCEEDS(ptet_session_update(session, NULL, NULL, NULL, NULL, &error));
  SUCCEEDS(ptet_session_update(session, NULL, NULL, NULL, &changes, &error));
  CHECK(changes.splits == 0 && changes.collapses == 0 && changes.changed_tet_count == 0); /* there is nothing to do */

  /* What cannot be met leaves the mesh as it was. */
  SUCCEEDS(ptet_request_add_field_error(request, "density", 1, 0, &error));
  FAILS(PTET_BAD_ARGUMENT, "density", ptet_session_update(session, request, NULL, NULL, &changes, &error));
  check_session(dataset, session, NULL, &changes, copy);
  struct counter counter = {0, 1};
  SUCCEEDS(ptet_request_clear(request, &error));
  SUCCEEDS(ptet_request_set_max_tets(request, TETS / 2, &error));
  FAILS(PTET_CANCELLED, "cancelled", ptet_session_update(session, request, count_progress, &counter, &changes, &error));
  CHECK(counter.calls == 1);
  check_session(dataset, session, NULL, &changes, copy);
  SUCCEEDS(ptet_session_update(session, NULL, count_progress, &counter, &changes, &error)); /* it is asked once more */
  CHECK(counter.calls == 2 && changes.complete == 1 && changes.splits == 0 && changes.renumbered == 0);
  SUCCEEDS(ptet_request_add_field_error(request, "density", 1, 0, &error));
  ptet_array array = {.struct_size = sizeof array};
  FAILS(PTET_BAD_ARGUMENT, "no field 3", ptet_session_get_field(session, 3, &array, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_session_get_field(session, 0, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "session is NULL", ptet_session_get_field(NULL, 0, &array, &error));
  FAILS(PTET_BAD_ARGUMENT, "is NULL", ptet_session_get_positions(session, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "session is NULL", ptet_session_get_positions(NULL, &array, &error));
  FAILS(PTET_BAD_ARGUMENT, "session is NULL", ptet_session_update(NULL, request, NULL, NULL, &changes, &error));
  changes.struct_size = offsetof(ptet_session_changes, renumbered); /* as of who does not know of it */
  changes.renumbered = 7;
  SUCCEEDS(ptet_session_update(session, NULL, NULL, NULL, &changes, &error));
  CHECK(changes.complete == 1 && changes.renumbered == 7);
  changes.struct_size = 8;
  FAILS(PTET_BAD_ARGUMENT, "struct_size", ptet_session_update(session, NULL, NULL, NULL, &changes, &error));
  ptet_extraction* extraction = NULL;
  FAILS(PTET_BAD_ARGUMENT, "session is NULL", ptet_session_extract(NULL, &extraction, &error));
  FAILS(PTET_BAD_ARGUMENT, "NULL", ptet_session_extract(session, NULL, &error));
  uint64_t slots = 1;
  CHECK(ptet_session_tets(NULL, &slots) == NULL && slots == 0);
  CHECK(ptet_session_boundary_faces(NULL, NULL) == NULL && ptet_session_vertices_in_file(NULL, NULL) == NULL);
  CHECK(ptet_session_made_by(NULL, &slots) == NULL && slots == 0);
  CHECK(ptet_session_tets(session, NULL) != NULL);
  const uint32_t no_such = UINT32_MAX - 1;
  double value = 0;
  FAILS(PTET_BAD_ARGUMENT, "no record", ptet_dataset_get_origin_values(dataset, &no_such, 1, 0, 0, &value, &error));
  FAILS(PTET_BAD_ARGUMENT, "does not govern",
        ptet_dataset_get_origin_values(dataset, &no_such, 1, PTET_ORIGIN_FIELD_ERROR, 2, &value, &error));
  FAILS(PTET_BAD_ARGUMENT, "origin value 4",
        ptet_dataset_get_origin_values(dataset, &no_such, 1, 4, 0, &value, &error));
  FAILS(PTET_BAD_ARGUMENT, "NULL", ptet_dataset_get_origin_values(dataset, NULL, 1, 0, 0, &value, &error));
  FAILS(PTET_BAD_ARGUMENT, "NULL", ptet_dataset_get_origin_values(dataset, &no_such, 1, 0, 0, NULL, &error));
  FAILS(PTET_BAD_ARGUMENT, "dataset is NULL", ptet_dataset_get_origin_values(NULL, &no_such, 1, 0, 0, &value, &error));
  CHECK(isnan(ptet_session_field_error(NULL, 0)) && isnan(ptet_session_rms_error(NULL, 0)));
  CHECK(isnan(ptet_session_covered(NULL)));
  ptet_session_free(session);
  ptet_session_free(NULL);
  ptet_request_free(request);
  free(copy);
}

int main(void) {
  make_mesh();
  test_versions_and_names();
  CHECK(ptet_error_status(NULL) == PTET_OK && strcmp(ptet_error_message(NULL), "") == 0);
  CHECK(ptet_error_offset(NULL) == UINT64_MAX);
  ptet_error_free(NULL);
  test_builder();
  test_builder_limits();

  ptet_builder* builder = quick_builder();
  ptet_bytes* bytes = build(builder);
  test_build_progress(builder, bytes);
  test_build_file(builder, bytes);
  ptet_builder_free(builder);
  test_corrupt_memory(bytes);
  test_source(bytes);

  ptet_dataset* dataset = NULL;
  SUCCEEDS(ptet_dataset_open_memory(ptet_bytes_data(bytes), ptet_bytes_size(bytes), NULL, &dataset, &error));
  ptet_bytes_free(bytes);
  REQUIRE(dataset != NULL);
  test_dataset(dataset);
  test_requests_refused(dataset);
  test_whole_extraction(dataset);
  test_input_order(dataset);
  test_welding();
  test_requests(dataset);
  test_sessions(dataset);
  ptet_dataset_free(dataset);
  printf("%d checks, %d failures\n", checks, failures);
  return failures == 0 ? 0 : 1;
}
