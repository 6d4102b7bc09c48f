#pragma once
#include <string>

#include "foreview/scene/camera_model.h"
#include "foreview/server/dds/messages.h"

namespace foreview {

/// The camera that a camera_info message describes: plumb_bob (also the rational model), equidistant, or none. Binning
/// and region of interest are worked in. Throws InputError at `where` on what cannot be (not calibrated, impossible
/// sizes, numbers that are not finite, an unknown distortion model).
[[nodiscard]] CameraModel camera_from_info(const CameraInfoMessage& info, const std::string& where);
/// The message without its header.
[[nodiscard]] CameraInfoMessage info_from_camera(const CameraModel& camera);

}  // namespace foreview
