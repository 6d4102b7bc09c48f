#include "foreview/scene/errors.h"

namespace foreview {

InputError::InputError(const std::string& where, const std::string& why) : std::runtime_error(where + ": " + why) {}

}  // namespace foreview
