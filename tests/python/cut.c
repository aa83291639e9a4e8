/* A mesh out of a .ptet file by the C interface, written as raw numbers for a test to compare:
 *
 *   cut FILE OUT [field NAME X | domain X | tets N | vertices N | box 6 NUMBERS | sphere X Y Z R | half NX NY NZ D |
 *                 obox 12 NUMBERS | region-error I X | region-falloff I X | values NAME MIN MAX | view 12 NUMBERS] ...
 *
 * Errors are fractions of the range (of the diagonal); a NAME "-" is every governing field. OUT holds the numbers of
 * vertices and tets (uint64), then points, tets and vertex ids as the interface gives them. */
#include <ptet/ptet.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char** next;

static const char* word(void) {
  if (*next == NULL) {
    fprintf(stderr, "cut: the request ends too soon\n");
    exit(2);
  }
  return *next++;
}

static const double* numbers(int count) {
  static double values[12];
  for (int i = 0; i < count; ++i)
    values[i] = strtod(word(), NULL);
  return values;
}

static void check(ptet_status status, ptet_error* error) {
  if (status == PTET_OK) return;
  fprintf(stderr, "cut: %s\n", ptet_error_message(error));
  exit(1);
}

static void add(ptet_request* request, const char* what) {
  ptet_error* error = NULL;
  ptet_status status = PTET_BAD_ARGUMENT;
  if (strcmp(what, "field") == 0) {
    const char* name = word();
    status = ptet_request_add_field_error(request, strcmp(name, "-") == 0 ? "" : name, *numbers(1), 1, &error);
  } else if (strcmp(what, "domain") == 0) {
    status = ptet_request_set_domain_error(request, *numbers(1), 1, &error);
  } else if (strcmp(what, "tets") == 0) {
    status = ptet_request_set_max_tets(request, strtoull(word(), NULL, 10), &error);
  } else if (strcmp(what, "vertices") == 0) {
    status = ptet_request_set_max_vertices(request, strtoull(word(), NULL, 10), &error);
  } else if (strcmp(what, "box") == 0) {
    const double* box = numbers(6);
    status = ptet_request_add_focus_box(request, box, box + 3, &error);
  } else if (strcmp(what, "sphere") == 0) {
    const double* sphere = numbers(4);
    status = ptet_request_add_focus_sphere(request, sphere, sphere[3], &error);
  } else if (strcmp(what, "half") == 0) {
    const double* half = numbers(4);
    status = ptet_request_add_focus_half_space(request, half, half[3], &error);
  } else if (strcmp(what, "obox") == 0) {
    const double* box = numbers(12);
    status = ptet_request_add_focus_oriented_box(request, box, box + 3, &error);
  } else if (strcmp(what, "region-error") == 0 || strcmp(what, "region-falloff") == 0) {
    const uint32_t region = (uint32_t)strtoul(word(), NULL, 10);
    status = strcmp(what, "region-error") == 0
                 ? ptet_request_set_region_error(request, region, *numbers(1), 1, &error)
                 : ptet_request_set_region_falloff(request, region, *numbers(1), 1, &error);
  } else if (strcmp(what, "values") == 0) {
    const char* name = word();
    const double* ends = numbers(2);
    status = ptet_request_add_values(request, name, ends[0], ends[1], &error);
  } else if (strcmp(what, "view") == 0) {
    ptet_view view = {.struct_size = sizeof view};
    const double* n = numbers(12);
    memcpy(view.eye, n, sizeof view.eye);
    memcpy(view.direction, n + 3, sizeof view.direction);
    memcpy(view.up, n + 6, sizeof view.up);
    view.vertical_angle = n[9];
    view.max_pixels = n[10];
    view.outside = n[11];
    view.width = 1920;
    view.height = 1080;
    status = ptet_request_set_view(request, &view, &error);
  }
  check(status, error);
}

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  next = argv + 3;
  ptet_error* error = NULL;
  ptet_dataset* data = NULL;
  ptet_request* request = ptet_request_new();
  ptet_extraction* cut = NULL;
  ptet_extraction_info info = {.struct_size = sizeof info};
  ptet_array points = {.struct_size = sizeof points};
  while (*next != NULL)
    add(request, word());
  check(ptet_dataset_open(argv[1], NULL, &data, &error), error);
  check(ptet_dataset_extract(data, request, NULL, NULL, &cut, &error), error);
  check(ptet_extraction_get_info(cut, &info, &error), error);
  check(ptet_extraction_get_positions(cut, &points, &error), error);
  FILE* file = fopen(argv[2], "wb");
  if (file == NULL) return 1;
  const size_t scalar = points.type == PTET_FLOAT64 ? 8 : 4;
  size_t written =
      fwrite(&info.vertices, sizeof info.vertices, 1, file) + fwrite(&info.tets, sizeof info.tets, 1, file);
  written += fwrite(points.data, 3 * scalar, info.vertices, file);
  written += fwrite(ptet_extraction_tets(cut), 16, info.tets, file);
  written += fwrite(ptet_extraction_vertices_in_file(cut), 4, info.vertices, file);
  const int is_whole = fclose(file) == 0 && written == 2 + 2 * info.vertices + info.tets;
  ptet_extraction_free(cut);
  ptet_request_free(request);
  ptet_dataset_free(data);
  return is_whole ? 0 : 1;
}
