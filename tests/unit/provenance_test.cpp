// The JSON of a manifest, read back and compared with what another writer makes of it.
#include "lod/provenance.hpp"

#include <random>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

using namespace ptet;
using Json = nlohmann::ordered_json;

TEST_CASE("provenance: strings are those of another writer") {
  std::mt19937 random(7);
  const std::vector<std::string> parts = {"a",
                                          "\"",
                                          "\\",
                                          "/",
                                          "\n",
                                          "\t",
                                          "\b",
                                          "\f",
                                          "\r",
                                          "\1",
                                          "\x1F",
                                          "\x7F",
                                          "\xC3\xA9",
                                          "\xE2\x82\xAC",
                                          "\xF0\x9F\x98\x80",
                                          " ",
                                          "\xED\x9F\xBF",
                                          "\xEF\xBF\xBF",
                                          "\xF4\x8F\xBF\xBF",
                                          std::string(1, '\0')};
  for (int i = 0; i < 2000; ++i) {
    std::string text;
    for (unsigned n = random() % 6; n > 0; --n)
      text += parts[random() % parts.size()];
    REQUIRE(json_string(text) == Json(text).dump());
  }
}

TEST_CASE("provenance: any bytes become JSON, and what is text in them stays") {
  std::mt19937 random(8);
  for (int i = 0; i < 20000; ++i) {
    std::string bytes;
    for (unsigned n = random() % 6; n > 0; --n)
      bytes += static_cast<char>(random() % 4 == 0 ? random() : 0x80 + random() % 128);
    const std::string json = json_string(bytes + "end");
    REQUIRE(Json::accept(json));
    bool is_text = true;
    try {
      (void)Json(bytes).dump();
    } catch (const Json::exception&) {
      is_text = false;
    }
    const std::string back = Json::parse(json).get<std::string>();
    REQUIRE((back == bytes + "end") == is_text);
    REQUIRE(back.substr(back.size() - 3) == "end");
  }
}

TEST_CASE("provenance: the manifest's members, in order; an option given twice is a list") {
  file::Manifest manifest;
  manifest.tool_version = "1.2.3";
  manifest.source_name = "a\"b.vtu";
  manifest.source_hash = "xxh64:0";
  manifest.options = {{"field", "p"}, {"method", "QN"}, {"field", "U"}, {"field", "T"}};
  manifest.notes = {"one", "two"};
  const Json expected = {{"tool_version", "1.2.3"},
                         {"source_name", "a\"b.vtu"},
                         {"source_hash", "xxh64:0"},
                         {"options", {{"field", {"p", "U", "T"}}, {"method", "QN"}}},
                         {"notes", {"one", "two"}}};
  CHECK(to_json(manifest) == expected.dump());
  CHECK(to_json({}) == R"({"tool_version":"","source_name":"","source_hash":"","options":{},"notes":[]})");
}
