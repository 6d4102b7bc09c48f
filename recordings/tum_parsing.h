#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "foreview/recordings/damage_log.h"
#include "foreview/recordings/recording.h"

namespace foreview {

/// Parsers of the text files of the TUM RGB-D conventions, on memory. `file` names the source in places. Nothing here
/// throws: what is damaged is dropped and noted in `damage`.

/// A line of rgb.txt: "STAMP FILE".
struct ListedPicture {
  Timestamp stamp;   ///< as written
  std::string file;  ///< relative; neither absolute nor leading out of the recording
  std::size_t line;  ///< from 1
};

/// In order of time; of equal stamps only the first.
[[nodiscard]] std::vector<ListedPicture> parse_picture_list(std::string_view text, const std::string& file,
                                                            DamageLog& damage);

/// Lines "STAMP TX TY TZ QX QY QZ QW".
[[nodiscard]] Trajectory parse_trajectory(std::string_view text, const std::string& file, DamageLog& damage);

/// Is this a path that stays within the directory it is relative to?
[[nodiscard]] bool stays_inside(const std::filesystem::path& relative);

}  // namespace foreview
