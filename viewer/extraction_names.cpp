#include "foreview/viewer/extraction_names.h"

#include <cstddef>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

template <typename Value, std::size_t N>
Value parse_choice(const std::string& text, const std::string& option, const Value (&choices)[N]) {
  std::string names;
  for (const Value choice : choices) {
    if (text == to_string(choice)) return choice;
    names += (names.empty() ? "" : ", ") + std::string(to_string(choice));
  }
  throw InputError(option, "'" + text + "' is none of its values: " + names);
}

}  // namespace

const char* to_string(ArtefactSuppression artefacts) {
  switch (artefacts) {
    case ArtefactSuppression::diamond:
      return "diamond";
    case ArtefactSuppression::alternating:
      return "alternating";
    case ArtefactSuppression::progressive:
      return "progressive";
    case ArtefactSuppression::none:
      break;
  }
  return "none";
}

const char* to_string(HoleFilling fill) {
  switch (fill) {
    case HoleFilling::pyramid:
      return "pyramid";
    case HoleFilling::iterative:
      return "iterative";
    case HoleFilling::none:
      break;
  }
  return "none";
}

const char* to_string(PipelineKind pipeline) {
  return pipeline == PipelineKind::batched ? "batched" : "per-polygon";
}

ArtefactSuppression parse_artefact_suppression(const std::string& text, const std::string& option) {
  return parse_choice(text, option,
                      {ArtefactSuppression::diamond, ArtefactSuppression::alternating, ArtefactSuppression::progressive,
                       ArtefactSuppression::none});
}

HoleFilling parse_hole_filling(const std::string& text, const std::string& option) {
  return parse_choice(text, option, {HoleFilling::pyramid, HoleFilling::iterative, HoleFilling::none});
}

const char* auto_or_off(bool on) {
  return on ? "auto" : "off";
}

bool parse_auto_or_off(const std::string& text, const std::string& option) {
  for (const bool on : {true, false}) {
    if (text == auto_or_off(on)) return on;
  }
  throw InputError(option, "'" + text + "' is none of its values: auto, off");
}

PipelineKind parse_pipeline(const std::string& text, const std::string& option) {
  return parse_choice(text, option, {PipelineKind::batched, PipelineKind::per_polygon});
}

}  // namespace foreview
