#include <fuzzer/FuzzedDataProvider.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <cstring>
#include <map>
#include <memory>
#include <vector>

#include "foreview/scene/errors.h"
#include "foreview/server/capture/v4l2_camera.h"
#include "require.h"

namespace {

using namespace foreview;

/// A driver that answers sensibly, but for what the input makes it spoil: errors at any call, and any bytes in any
/// answer.
class SpoiltDriver : public VideoSystem {
 public:
  explicit SpoiltDriver(FuzzedDataProvider& input) : input_(input) {}

  int open(const std::string& /*path*/, int /*flags*/) override { return spoilt_error(3); }
  int close(int /*file*/) override { return 0; }
  void* mmap(std::size_t length, int /*file*/, std::int64_t /*offset*/, int& error) override {
    error = -ENOMEM;
    constexpr std::size_t kMost = std::size_t{1} << 20;
    if (length == 0 || length > kMost || spoilt_error(0) < 0) return nullptr;
    auto memory = std::make_unique<std::vector<unsigned char>>(length);
    const std::vector<unsigned char> bytes = input_.ConsumeBytes<unsigned char>(std::min<std::size_t>(length, 64));
    std::copy(bytes.begin(), bytes.end(), memory->begin());
    void* const address = memory->data();
    memory_[address] = std::move(memory);
    return address;
  }
  int munmap(void* address, std::size_t length) override {
    const auto found = memory_.find(address);
    FUZZ_REQUIRE(found != memory_.end() && found->second->size() == length);
    memory_.erase(found);
    return 0;
  }
  int poll(pollfd* files, std::size_t count, int timeout_ms) override {
    FUZZ_REQUIRE(timeout_ms >= 0);
    now_ = now_ + Duration{std::int64_t{timeout_ms} * 1'000'000 / 4 + 1000};
    if (count == 0) return 0;
    files->revents = input_.remaining_bytes() > 0 ? input_.ConsumeIntegral<short>() : 0;
    return spoilt_error(files->revents != 0 ? 1 : 0);
  }
  Timestamp now(clockid_t clock) override { return clock == CLOCK_REALTIME ? now_ + Duration{1 << 30} : now_; }

  int ioctl(int /*file*/, unsigned long request, void* argument) override {
    FUZZ_REQUIRE(++calls_ < 1'000'000);
    const int result = answer(request, argument);
    if (input_.remaining_bytes() == 0) return request == VIDIOC_DQBUF ? -ENODEV : result;
    if ((_IOC_DIR(request) & _IOC_READ) != 0 && input_.ConsumeProbability<float>() < 0.2F) {
      const std::size_t size = _IOC_SIZE(request);
      const std::size_t at = input_.ConsumeIntegralInRange<std::size_t>(0, size - 1);
      const std::vector<unsigned char> bytes = input_.ConsumeBytes<unsigned char>(
          input_.ConsumeIntegralInRange<std::size_t>(0, std::min<std::size_t>(8, size - at)));
      std::memcpy(static_cast<char*>(argument) + at, bytes.data(), bytes.size());
    }
    return spoilt_error(result);
  }
  [[nodiscard]] std::size_t mappings() const { return memory_.size(); }

 private:
  int spoilt_error(int result) {
    if (input_.remaining_bytes() == 0 || input_.ConsumeProbability<float>() > 0.05F) return result;
    return -input_.ConsumeIntegralInRange<int>(1, 133);
  }

  int answer(unsigned long request, void* argument) {
    switch (request) {
      case VIDIOC_QUERYCAP:
        static_cast<v4l2_capability*>(argument)->capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
        return 0;
      case VIDIOC_ENUM_FMT: {
        auto& format = *static_cast<v4l2_fmtdesc*>(argument);
        constexpr std::uint32_t kFormats[] = {V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_YUYV};
        if (format.index >= 3) return -EINVAL;
        format.pixelformat = kFormats[format.index];
        return 0;
      }
      case VIDIOC_ENUM_FRAMESIZES: {
        auto& size = *static_cast<v4l2_frmsizeenum*>(argument);
        if (size.index > 0) return -EINVAL;
        size.type = V4L2_FRMSIZE_TYPE_DISCRETE;
        size.discrete = {4, 2};
        return 0;
      }
      case VIDIOC_ENUM_FRAMEINTERVALS: {
        auto& interval = *static_cast<v4l2_frmivalenum*>(argument);
        if (interval.index > 0) return -EINVAL;
        interval.type = V4L2_FRMIVAL_TYPE_DISCRETE;
        interval.discrete = {1, 30};
        return 0;
      }
      case VIDIOC_S_FMT: {
        auto& pixels = static_cast<v4l2_format*>(argument)->fmt.pix;
        pixels.sizeimage = 64;
        return 0;
      }
      case VIDIOC_QUERYBUF:
        static_cast<v4l2_buffer*>(argument)->length = 4096;
        return 0;
      case VIDIOC_DQBUF: {
        auto& buffer = *static_cast<v4l2_buffer*>(argument);
        buffer.index = sequence_ % 4;
        buffer.sequence = sequence_++;
        buffer.bytesused = 8;
        buffer.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
        buffer.timestamp.tv_sec = now_.nanoseconds / 1'000'000'000;
        buffer.timestamp.tv_usec = now_.nanoseconds % 1'000'000'000 / 1000;
        return 0;
      }
      default:
        return 0;
    }
  }

  FuzzedDataProvider& input_;
  std::map<void*, std::unique_ptr<std::vector<unsigned char>>> memory_;
  Timestamp now_{1'000'000'000};
  std::uint32_t sequence_ = 0;
  std::size_t calls_ = 0;
};

}  // namespace

// Whatever a driver answers: pictures of the agreed size come out or an InputError of one line, all memory is given
// back, and no call goes on for ever.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  FuzzedDataProvider input(data, size);
  V4l2Camera::Options options;
  options.reopen = input.ConsumeBool();
  options.stamp_on_arrival = input.ConsumeBool();
  options.newest_only = input.ConsumeBool();
  if (input.ConsumeBool()) options.wish = {.format = {}, .width = 4, .height = 2, .rate = 15};
  SpoiltDriver driver(input);
  try {
    V4l2Camera camera(options, driver);
    for (int i = 0; i < 50; ++i) {
      const std::optional<CapturedPicture> picture = camera.next(Duration{100'000'000});
      if (!picture) continue;
      const std::size_t pixel = bytes_per_pixel(camera.mode().format);
      const auto pixels = static_cast<std::size_t>(picture->width) * static_cast<std::size_t>(picture->height);
      FUZZ_REQUIRE(picture->bytes.size() == pixels * pixel || pixel == 0);
    }
  } catch (const InputError& error) {
    FUZZ_REQUIRE(std::string(error.what()).find('\n') == std::string::npos);
  }
  FUZZ_REQUIRE(driver.mappings() == 0);
  return 0;
}
