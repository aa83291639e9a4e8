// Opens a .ptet file and takes two meshes out of it: all of it, and a coarse one within an error.
#include <cstdio>

#include <ptet/bounds.hpp>
#include <ptet/dataset.hpp>
#include <ptet/error.hpp>
#include <ptet/ids.hpp>
#include <ptet/mesh.hpp>
#include <ptet/progress.hpp>
#include <ptet/validate.hpp>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    const auto data = ptet::Dataset::open(argv[1]);
    const ptet::Extraction whole = data->extract({});
    ptet::Request request;
    request.field_error.push_back({"", {0.1, true}});
    const ptet::Extraction coarse = data->extract(request);
    std::printf("%zu tets, and %zu with an error of %g\n", whole.mesh.tets.size(), coarse.mesh.tets.size(),
                coarse.field_error.at(0));
    const bool good = whole.mesh.tets.size() == data->info().tets && whole.field_error.at(0) == 0 &&
                      coarse.mesh.tets.size() < whole.mesh.tets.size() &&
                      coarse.field_error.at(0) <= 0.1 * data->info().fields.at(0).range;
    return good ? 0 : 1;
  } catch (const ptet::Error& error) {
    std::fprintf(stderr, "cut_file: %s\n", error.what());
    return 1;
  }
}
