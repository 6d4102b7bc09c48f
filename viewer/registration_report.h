#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "foreview/calib/registration.h"

namespace foreview {

/// How pictures are being registered, in a few words: "off" (none), "looking for landmarks", "the record fits
/// (0.4 px off)", "5.9 px off, now 1.5" (where it is corrected).
[[nodiscard]] std::string to_text(const std::optional<RegistrationStatus>& status);
/// null (none), or an object with the members of RegistrationStatus that docs/evaluation.md describes.
[[nodiscard]] nlohmann::ordered_json to_json(const std::optional<RegistrationStatus>& status);

}  // namespace foreview
