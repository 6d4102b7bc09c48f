#pragma once
#include <string>

#include "foreview/gpu/extraction.h"

namespace foreview {

/// The words by which options, help and reports call the variants of the extraction.
/// "diamond", "alternating", "progressive", "none". InputError naming `option` lists them.
[[nodiscard]] ArtefactSuppression parse_artefact_suppression(const std::string& text, const std::string& option);
/// "pyramid", "iterative", "none".
[[nodiscard]] HoleFilling parse_hole_filling(const std::string& text, const std::string& option);
/// "batched", "per-polygon".
[[nodiscard]] PipelineKind parse_pipeline(const std::string& text, const std::string& option);
/// "auto": true, "off": false.
[[nodiscard]] bool parse_auto_or_off(const std::string& text, const std::string& option);
[[nodiscard]] const char* auto_or_off(bool on);
[[nodiscard]] const char* to_string(ArtefactSuppression artefacts);
[[nodiscard]] const char* to_string(HoleFilling fill);
[[nodiscard]] const char* to_string(PipelineKind pipeline);

}  // namespace foreview
