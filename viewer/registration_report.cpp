#include "foreview/viewer/registration_report.h"

#include <nlohmann/json.hpp>

#include "foreview/viewer/formatted.h"

namespace foreview {

std::string to_text(const std::optional<RegistrationStatus>& status) {
  if (!status) return "off";
  if (status->is_correcting) {
    return formatted("%.1f px off, now %.1f", status->error_recorded, status->error_registered);
  }
  if (status->error_recorded > 0) return formatted("the record fits (%.1f px off)", status->error_recorded);
  return "looking for landmarks";
}

nlohmann::ordered_json to_json(const std::optional<RegistrationStatus>& status) {
  if (!status) return nullptr;
  return {{"is_correcting", status->is_correcting},
          {"error_recorded", status->error_recorded},
          {"error_registered", status->error_registered},
          {"pictures", status->pictures},
          {"searched", status->searched},
          {"registered", status->registered},
          {"landmarks", status->landmarks}};
}

}  // namespace foreview
