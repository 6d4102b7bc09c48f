#include "foreview/viewer/viewer_stage.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "foreview/viewer/panels.h"

namespace foreview {
namespace {

constexpr float kSmallestWidth = 43;  // in heights of text; small pictures are enlarged to about this

LiveScene::Options scene_options(const Feed& feed, const ExtractionOptions& extraction) {
  LiveScene::Options options = feed.scene_options(extraction);
  options.beside_display = true;
  return options;
}

}  // namespace

ViewerStage::ViewerStage(Window& window, Feed& feed, ViewerControl& control)
    : window_(window),
      feed_(feed),
      control_(control),
      interface_(window),
      scene_(feed.model(), scene_options(feed, control.settings().extraction), window.egl_display(),
             window.egl_context(), [&window] { window.make_current(); }),
      view_(scene_.store()),
      frames_(feed.source(), feed.camera(), feed.recording()),
      camera_model_(feed.camera_model()) {
  make_composer();
}

void ViewerStage::make_composer() {
  const double near_plane = control_.settings().extraction.near_plane;
  composer_.emplace(view_, camera_model_, near_plane);
  probe_.emplace(view_, camera_model_.undistorted(), near_plane);
  control_.set_camera(camera_model_.undistorted());
}

void ViewerStage::tell_probe(ViewerStatus& status) const {
  status.polygon.reset();
  status.polygon_found = control_.settings().probe && probe_->found().has_value();
  if (!status.polygon_found) return;
  status.polygon = probe_->report();
  status.polygon_distance = probe_->found()->distance;
  status.texel_captured = probe_->found()->captured;
}

FrameComposer::Size ViewerStage::wanted_window() const {
  const FrameComposer::Size native = composer_->native_size(control_.settings().choice.mode);
  const int enlarged = std::max(1, static_cast<int>(kSmallestWidth * interface_.em()) / std::max(native.width, 1));
  FrameComposer::Size size{native.width * enlarged, native.height * enlarged};
  if (control_.settings().panels) {
    size.width += static_cast<int>(std::lround(side_panel_width(interface_.em())));
    size.height += static_cast<int>(std::lround(timeline_height(interface_.em())));
  }
  return size;
}

void ViewerStage::take_in_mouse() {
  const PointerState pointer = interface_.pointer();
  FramePointer frame;
  const glm::dvec2 corner{view_area_.x + (view_area_.width - frame_size_.width) / 2,
                          view_area_.y + (view_area_.height - frame_size_.height) / 2};
  // Side by side, the mouse looks at the picture that it is over.
  const int columns = view_columns(control_.settings().choice.mode);
  frame.frame_size = {frame_size_.width / columns, frame_size_.height};
  frame.position = pointer.position - corner;
  frame.over_frame = pointer.over_view && frame.position.x >= 0 && frame.position.y >= 0 &&
                     frame.position.x < frame_size_.width && frame.position.y < frame_size_.height;
  frame.left = pointer.left;
  frame.right = pointer.right;
  frame.left_pressed = pointer.left_pressed && frame.over_frame;
  frame.right_pressed = pointer.right_pressed && frame.over_frame;
  frame.shift = pointer.shift;
  frame.wheel = pointer.wheel;
  if (control_.over_split(frame)) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  control_.point(frame);
  cursor_.reset();
  if (frame.over_frame) cursor_ = frame.position;
}

void ViewerStage::advance_camera(const FrameMoment& moment, Timestamp t) {
  const double passed = advanced_to_ ? (moment.now - *advanced_to_).seconds() : 0;
  advanced_to_ = moment.now;
  control_.hold(interface_.wants_keys() ? std::bitset<kMoveKeys>{} : window_.held_moves());
  const Timestamp now = feed_.source().time_at(moment.now);
  const auto recorded_now = feed_.source().predicted_state(now), recorded_then = feed_.source().predicted_state(t);
  if (!recorded_then) return;
  // Long pauses (a menu of the window system, a debugger) are no movement.
  constexpr double kLongest = 0.25;
  control_.advance(std::clamp(passed, 0.0, kLongest),
                   (recorded_now ? *recorded_now : *recorded_then).world_from_camera);
}

void ViewerStage::draw(const FrameMoment& moment, Timestamp t, Timestamp since, const ViewerStatus& status) {
  // Live, it becomes known, and may change.
  if (CameraModel model = feed_.camera_model(); !is_same_camera(model, camera_model_)) {
    camera_model_ = std::move(model);
    make_composer();
  }
  interface_.begin();
  if (control_.take_enter_request()) interface_.enter();
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  layout_ = lay_out_panels(size.x, size.y, interface_.em(), control_.settings().panels);
  const float pixels = size.x > 0 ? static_cast<float>(window_.width()) / size.x : 1;
  view_area_ = {0, 0, std::max(static_cast<int>(layout_.view.width * pixels), 1),
                std::max(static_cast<int>(layout_.view.height * pixels), 1)};
  const ViewChoice& choice = control_.settings().choice;
  frame_size_ = composer_->fitting_size(choice.mode, view_area_.width, view_area_.height);
  take_in_mouse();
  advance_camera(moment, t);
  show_panels({control_, status, interface_.em()}, layout_);

  // After the panels, whose sliders it shows at once; mode and size are as the panels left them.
  frame_size_ = composer_->fitting_size(choice.mode, view_area_.width, view_area_.height);
  const double ahead = (moment.seen - moment.now).seconds();
  shown_ = &frames_.at(t, since, moment, choice,
                       [&](const Pose& recorded) { return control_.camera().pose_ahead(ahead, recorded); });
  ViewChoice drawn = choice;
  if (display_quality_ == ViewQuality::fast) drawn.quality = ViewQuality::fast;
  composer_->compose(*shown_, drawn, frame_size_);
  control_.settings().choice.polygon.reset();
  if (control_.settings().probe && scene_.is_ready()) {
    probe_->update(*shown_, choice, frame_size_, cursor_);
    if (probe_->found()) control_.settings().choice.polygon = probe_->found()->polygon;
  }
  window_.draw(composer_->framebuffer(), frame_size_.width, frame_size_.height, view_area_);
  interface_.end();
}

cv::Mat ViewerStage::take_picture() {
  if (shown_ == nullptr) return {};
  const ViewChoice& choice = control_.settings().choice;
  composer_->compose(*shown_, choice, composer_->native_size(choice.mode));
  return composer_->read();
}

void ViewerStage::set_extraction(const ExtractionOptions& options) {
  scene_.replace_extraction(options);
  make_composer();
}

}  // namespace foreview
