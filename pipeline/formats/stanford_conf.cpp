#include "pipeline/formats/stanford_conf.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace meshmser {

std::vector<PosedFile> read_stanford_conf(const FileBytes& file) {
  const char terminator = line_terminator({file.begin(), file.size()});
  Lines lines(file.begin(), file.end(), terminator);
  std::vector<PosedFile> files;
  std::string_view line;
  while (lines.next_filled(line)) {
    const std::string_view whole = line;
    const std::string_view key = take_word(line);
    if (key == "camera" || key.starts_with('#')) continue;
    if (key != "bmesh" && key != "mesh")
      file.fail_at(
          whole.data(),
          fmt::format("{} is not a line of a .conf; expected 'bmesh FILE tx ty tz qx qy qz qw' or 'camera ...'",
                      in_quotes(whole)),
          terminator);
    const std::string_view name = take_word(line);
    if (name.empty())
      file.fail_at(whole.data(), "no file is named; expected 'bmesh FILE tx ty tz qx qy qz qw'", terminator);
    std::array<double, 7> v{};
    for (double& value : v) {
      const std::string_view word = take_word(line);
      if (word.empty() || parse_number(word.data(), word.data() + word.size(), value) != word.data() + word.size() ||
          !std::isfinite(value))
        file.fail_at(whole.data(),
                     fmt::format("{} is not a number; expected 'bmesh FILE tx ty tz qx qy qz qw'", in_quotes(word)),
                     terminator);
    }
    if (!take_word(line).empty())
      file.fail_at(whole.data(),
                   fmt::format("too many values: {}; expected 'bmesh FILE tx ty tz qx qy qz qw'", in_quotes(whole)),
                   terminator);
    const Eigen::Quaterniond stored(v[6], v[3], v[4], v[5]);
    constexpr double kTolerance = 1e-2;
    if (std::abs(stored.norm() - 1) > kTolerance)
      file.fail_at(whole.data(),
                   fmt::format("the quaternion has length {:.4g}; expected 1, as qx qy qz qw", stored.norm()),
                   terminator);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = stored.normalized().conjugate().toRotationMatrix();
    pose.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
    files.push_back({file.path().parent_path() / name, pose});
  }
  if (files.empty()) file.fail("names no files; expected lines 'bmesh FILE tx ty tz qx qy qz qw'");
  return files;
}

}  // namespace meshmser
