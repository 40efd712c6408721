#pragma once
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "stages/common/colours.hpp"

namespace meshmser {

/// Rows from the top, each from the left, three bytes a pixel.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  ///< 3 * width * height

  Image() = default;
  Image(int width, int height, const Colour& fill);

  Colour at(int x, int y) const;
  /// Sets a pixel; outside the image nothing happens.
  void set(int x, int y, const Colour& colour);
  void fill_rectangle(int x, int y, int rectangle_width, int rectangle_height, const Colour& colour);
  /// Copies `other` with its upper left corner at (x, y); what lies outside is cut.
  void paste(const Image& other, int x, int y);
};

/// Pixels that `text` takes in width at a whole magnification `size` of the font, six pixels a character.
int text_width(std::string_view text, int size);

/// Draws one line of ASCII text, its upper left corner at (x, y), 7 * size pixels high without descenders.
void draw_text(Image& image, int x, int y, std::string_view text, int size, const Colour& colour);

/// Writes an 8-bit RGB PNG. The same image gives the same bytes. Throws CacheError when the file cannot be written.
void write_png(const std::filesystem::path& path, const Image& image);

/// Reads a PNG of any kind as 8-bit RGB (transparency over white). Throws InputError when the file is no PNG or
/// damaged.
Image read_png(const std::filesystem::path& path);

}  // namespace meshmser
