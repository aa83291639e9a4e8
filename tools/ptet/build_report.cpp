#include "build_report.hpp"

#include "build_methods.hpp"
#include "console.hpp"
#include "plain_output.hpp"

#include <algorithm>
#include <array>
#include <iostream>
#include <numeric>

namespace ptet::cli {
namespace {

/// Of those that this run searched for.
double collapses_per_second(const BuildReport& report) {
  const auto found = static_cast<double>(report.records - report.resumed_records);
  const double seconds = report.piece_seconds + report.follow_seconds + report.collapse_seconds;
  return seconds > 0 ? found / seconds : 0;
}

double per(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

/// What the file has of a governing field; its errors are in the order of the arrays, those of a report in the order in
/// which the fields were named.
struct StatedField {
  double range = 0;
  double error = 0; ///< the largest of the base mesh
};
StatedField stated(const DatasetInfo& info, const std::string& name) {
  std::size_t column = 0;
  for (const FieldInfo& field : info.fields) {
    if (!field.governing) continue;
    if (field.name == name) return {field.range, info.max_field_error[column]};
    ++column;
  }
  return {};
}

void print_input(const BuildOutcome& outcome, std::ostream& out) {
  const BuildReport& build = outcome.build;
  out << "built " << outcome.output << " from " << outcome.input << " in " << brief(build.total_seconds, 3) << " s\n";
  out << "  input     " << outcome.read.format << ", " << counted(build.input_vertices, "vertex") << ", "
      << counted(build.input_tets, "tet") << ", " << counted(outcome.input_bytes, "byte") << '\n';
  const BuildOptions& options = outcome.options;
  const char* const method = method_of(options);
  out << "  method    " << (method != nullptr ? std::string(method) + ": " : "") << "predict "
      << name_of(options.prediction) << ", evaluate " << name_of(options.evaluation);
  if (simulates(options)) out << ", objective " << name_of(options.objective);
  out << '\n';
  for (const std::string& note : outcome.read.notes)
    out << "  note      " << on_one_line(note) << '\n';
  for (const std::string& note : build.notes)
    out << "  note      " << on_one_line(note) << '\n';
}

std::string text_of(const Bound& bound) {
  return bound.relative ? brief(100 * bound.value, 3) + "%" : brief(bound.value, 3);
}

/// Which option to change where a build came to an end before its target: of those that refuse collapses the one that
/// refused most of the last. Empty where none refused one in twenty.
std::string hint_of(const BuildReport& build, const BuildOptions& options) {
  struct Limit {
    CollapseStatus status;
    std::string option;
    const char* change;
  };
  const std::array<Limit, 4> limits{
      {{CollapseStatus::kStarTooLarge, "--max-star " + std::to_string(options.max_star), "larger"},
       {CollapseStatus::kQuality, "--min-quality " + brief(build.min_quality, 3), "smaller"},
       {CollapseStatus::kDomainError, "--max-domain-error " + text_of(options.max_domain_error), "larger"},
       {CollapseStatus::kFieldError, "--max-field-error", "larger"}}};
  const auto count = [&](CollapseStatus status) {
    const bool is_at_its_end = status == CollapseStatus::kStarTooLarge && options.max_star >= kGreatestMaxStar;
    return is_at_its_end ? 0 : build.last_refusals[static_cast<std::size_t>(status)];
  };
  const auto most = std::max_element(limits.begin(), limits.end(),
                                     [&](const Limit& a, const Limit& b) { return count(a.status) < count(b.status); });
  const std::uint64_t all = std::accumulate(build.last_refusals.begin(), build.last_refusals.end(), std::uint64_t{0});
  if (count(most->status) == 0 || count(most->status) < all / 20) return {};
  return most->option + " refused " + grouped(count(most->status)) + " of the last " + grouped(all) +
         " collapses that were tried; a " + most->change + " one may let more go";
}

void print_collapses(const BuildOutcome& outcome, std::ostream& out) {
  const BuildReport& build = outcome.build;
  out << "  base      " << counted(build.base_vertices, "vertex") << " ("
      << percent(static_cast<double>(build.base_vertices), static_cast<double>(build.input_vertices)) << "), "
      << counted(build.base_tets, "tet") << "; stopped by: " << build.stopped_by << '\n';
  if (const std::string hint = hint_of(build, outcome.options); !hint.empty()) out << "  hint      " << hint << '\n';
  out << "  records   " << grouped(build.records) << " in " << counted(build.rounds, "round") << ", depth "
      << grouped(build.depth) << '\n';
  std::string refused;
  for (std::size_t i = 0; i < kCollapseStatusCount; ++i) {
    const auto status = static_cast<CollapseStatus>(i);
    if (status == CollapseStatus::kAccepted || build.collapses[i] == 0) continue;
    refused += (refused.empty() ? "" : ", ") + std::string(name_of(status)) + " " + grouped(build.collapses[i]);
  }
  out << "  refused   " << (refused.empty() ? "none" : refused) << '\n';
}

void print_errors(const BuildOutcome& outcome, std::ostream& out) {
  const BuildReport& build = outcome.build;
  const auto share = [](double error, double whole) {
    const std::string text = percent_up(error, whole);
    return text.empty() ? text : " (" + text;
  };
  // Of the base mesh as the file states it, and where limits are on what lies outside of it, too.
  for (const auto& [field, everywhere] : build.field_error) {
    const auto [range, error] = stated(outcome.info, field);
    const std::string of_range = share(error, range);
    out << "  error     " << on_one_line(field) << " up to " << brief_up(error)
        << (of_range.empty() ? "" : of_range + " of its range)");
    if (everywhere > error)
      out << "; at vertices outside of a mesh up to " << brief_up(everywhere) << share(everywhere, range)
          << (of_range.empty() ? "" : ")");
    out << '\n';
  }
  const std::string of_diagonal = share(outcome.info.max_domain_error, outcome.info.diagonal);
  out << "  error     domain up to " << brief_up(outcome.info.max_domain_error)
      << (of_diagonal.empty() ? "" : of_diagonal + " of the diagonal)") << '\n';
  if (!outcome.info.errors_are_bounds) out << "  note      " << kNoBounds << '\n';
}

void print_costs(const BuildOutcome& outcome, std::ostream& out) {
  const BuildReport& build = outcome.build;
  out << "  file      " << counted(build.file_bytes, "byte") << ", "
      << brief(per(build.file_bytes, build.input_vertices), 3) << " a vertex, "
      << brief(per(build.file_bytes, outcome.input_bytes), 3) << " of the input file\n";
  if (build.peak_memory_bytes > 0)
    out << "  memory    " << counted(build.peak_memory_bytes, "byte") << " at most, "
        << brief(per(build.peak_memory_bytes, build.input_tets), 3) << " an input tet; "
        << counted(build.foreseen_memory_bytes, "byte") << " were foreseen\n";
  if (outcome.options.checkpoint.resume)
    out << "  resumed   after " << counted(build.resumed_records, "collapse") << ", made again in "
        << brief(build.resume_seconds, 3) << " s\n";
  if (build.checkpoints > 0)
    out << "  saved     " << counted(build.checkpoints, "checkpoint") << " of up to "
        << counted(build.checkpoint_bytes, "byte") << " in " << brief(build.checkpoint_seconds, 3) << " s\n";
  if (build.checkpoints_failed > 0)
    out << "  not saved " << counted(build.checkpoints_failed, "checkpoint") << ": " << build.checkpoint_failure
        << '\n';
  if (build.pieces > 1) {
    out << "  pieces    " << grouped(build.pieces) << ", " << counted(build.piece_records, "collapse") << " in "
        << brief(build.piece_seconds, 3) << " s, made again in the whole in " << brief(build.follow_seconds, 3) << " s";
    if (build.piece_records_dropped > 0) out << "; " << grouped(build.piece_records_dropped) << " more not possible";
    out << '\n';
  }
  out << "  speed     " << counted(build.records - build.resumed_records, "collapse") << " in "
      << brief(build.piece_seconds + build.follow_seconds + build.collapse_seconds, 3) << " s, "
      << grouped(static_cast<std::uint64_t>(collapses_per_second(build))) << "/s\n";
  if (build.certify_seconds > 0)
    out << "  certified exact field errors in " << brief(build.certify_seconds, 3) << " s\n";
}

} // namespace

void print_json(const BuildOutcome& outcome) {
  const BuildReport& build = outcome.build;
  Json collapses = Json::object(), last_refusals = Json::object();
  for (std::size_t i = 0; i < kCollapseStatusCount; ++i) {
    const auto status = static_cast<CollapseStatus>(i);
    collapses[std::string(name_of(status))] = build.collapses[i];
    if (build.last_refusals[i] > 0) last_refusals[std::string(name_of(status))] = build.last_refusals[i];
  }
  Json field_error = Json::object(), stated_field_error = Json::object();
  for (const auto& [field, error] : build.field_error) {
    field_error[field] = error;
    stated_field_error[field] = stated(outcome.info, field).error;
  }
  std::vector<std::string> notes = outcome.read.notes;
  notes.insert(notes.end(), build.notes.begin(), build.notes.end());

  Json walk = Json::array();
  for (const RoundReport& step : build.walk)
    walk.push_back({{"vertices", step.vertices},
                    {"cost", step.cost},
                    {"field_error", step.field_error},
                    {"domain_error", step.domain_error}});

  Json json;
  json["input"] = {{"path", outcome.input},
                   {"format", outcome.read.format},
                   {"bytes", outcome.input_bytes},
                   {"vertices", build.input_vertices},
                   {"tets", build.input_tets}};
  json["output"] = outcome.output;
  const BuildOptions& options = outcome.options;
  const char* const method = method_of(options);
  json["method"] = method != nullptr ? Json(method) : Json();
  json["predict"] = name_of(options.prediction);
  json["evaluate"] = name_of(options.evaluation);
  json["objective"] = simulates(options) ? Json(name_of(options.objective)) : Json();
  json["weld"] = options.weld.has_value();
  json["keep_order"] = options.keep_order;
  json["notes"] = notes;
  json["base"] = {{"vertices", build.base_vertices}, {"tets", build.base_tets}};
  json["records"] = build.records;
  json["rounds"] = build.rounds;
  json["depth"] = build.depth;
  json["cut_dependencies"] = build.cut_dependencies;
  json["min_quality"] = build.min_quality;
  json["stopped_by"] = build.stopped_by;
  json["last_refusals"] = last_refusals;
  json["collapses"] = collapses;
  json["simulations"] = build.simulations;
  json["exact_evaluations"] = build.exact_evaluations;
  json["field_error"] = field_error;
  json["domain_error"] = build.domain_error;
  json["stated"] = {{"field_error", stated_field_error}, {"domain_error", outcome.info.max_domain_error}};
  json["walk"] = walk;
  json["file_bytes"] = build.file_bytes;
  json["bytes_per_vertex"] = per(build.file_bytes, build.input_vertices);
  json["peak_memory_bytes"] = build.peak_memory_bytes;
  json["foreseen_memory_bytes"] = build.foreseen_memory_bytes;
  json["peak_memory_bytes_per_tet"] = per(build.peak_memory_bytes, build.input_tets);
  json["ratio_to_input"] = per(build.file_bytes, outcome.input_bytes);
  json["collapse_seconds"] = build.collapse_seconds;
  json["certify_seconds"] = build.certify_seconds;
  json["collapses_per_second"] = collapses_per_second(build);
  json["seconds"] = build.total_seconds;
  json["pieces"] = {{"count", build.pieces},
                    {"records", build.piece_records},
                    {"dropped", build.piece_records_dropped},
                    {"seconds", build.piece_seconds},
                    {"follow_seconds", build.follow_seconds}};
  json["resumed_records"] = build.resumed_records;
  json["resume_seconds"] = build.resume_seconds;
  json["checkpoints"] = {
      {"written", build.checkpoints}, {"bytes", build.checkpoint_bytes}, {"seconds", build.checkpoint_seconds}};
  if (build.checkpoints_failed > 0) {
    json["checkpoints"]["failed"] = build.checkpoints_failed;
    json["checkpoints"]["failure"] = build.checkpoint_failure;
  }
  print(json);
}

void print_text(const BuildOutcome& outcome) {
  print_input(outcome, std::cout);
  print_collapses(outcome, std::cout);
  print_errors(outcome, std::cout);
  print_costs(outcome, std::cout);
}

} // namespace ptet::cli
