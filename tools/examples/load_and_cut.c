/* Opens a .ptet file, takes a mesh out of it within an error, and reads its arrays where they are.
 *
 *   load_and_cut_c FILE.ptet */
#include <ptet/ptet.h>
#include <stdio.h>

/* Goes on while all is well: each call does nothing after one that failed. */
#define TRY(call) (failure == NULL && (call) == PTET_OK)

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  ptet_error* failure = NULL;
  ptet_dataset* data = NULL;
  ptet_request* request = ptet_request_new();
  ptet_extraction* cut = NULL;
  ptet_extraction_info info = {.struct_size = sizeof info};
  ptet_array positions = {.struct_size = sizeof positions};

  if (TRY(ptet_dataset_open(argv[1], NULL, &data, &failure)) &&
      TRY(ptet_request_add_field_error(request, NULL, 0.02, 1, &failure)) && /* every field: 2% of its range */
      TRY(ptet_request_set_domain_error(request, 0.01, 1, &failure)) &&      /* 1% of the diagonal */
      TRY(ptet_dataset_extract(data, request, NULL, NULL, &cut, &failure)) &&
      TRY(ptet_extraction_get_info(cut, &info, &failure)) &&
      TRY(ptet_extraction_get_positions(cut, &positions, &failure))) {
    printf("cut: %llu vertices, %llu tets, limited by %s\n", (unsigned long long)info.vertices,
           (unsigned long long)info.tets, ptet_limit_name(info.limited_by));
    ptet_field_info field = {.struct_size = sizeof field};
    for (uint32_t f = 0; f < info.fields && TRY(ptet_dataset_get_field(data, f, &field, &failure)); ++f)
      if (field.governing)
        printf("%s within %g, of a range of %g\n", field.name, ptet_extraction_field_error(cut, f), field.range);

    const uint32_t* tet = ptet_extraction_tets(cut); /* four vertices each */
    if (info.tets > 0 && positions.type == PTET_FLOAT32)
      for (int corner = 0; corner < 4; ++corner) {
        const float* p = (const float*)positions.data + 3 * (size_t)tet[corner];
        printf("a corner of the first tet: %g %g %g\n", p[0], p[1], p[2]);
      }
  }
  const int result = failure == NULL ? 0 : 1;
  if (failure != NULL) fprintf(stderr, "%s\n", ptet_error_message(failure));
  ptet_error_free(failure);
  ptet_extraction_free(cut);
  ptet_request_free(request);
  ptet_dataset_free(data);
  return result;
}
