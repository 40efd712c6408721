#include "stages/export/image.hpp"

#include <png.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "pipeline/execution/error.hpp"
#include "stages/export/font.hpp"

namespace meshmser {

Image::Image(int image_width, int image_height, const Colour& fill) : width(image_width), height(image_height) {
  rgb.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = fill[i % 3];
}

Colour Image::at(int x, int y) const {
  const std::size_t i =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  return {rgb[i], rgb[i + 1], rgb[i + 2]};
}

void Image::set(int x, int y, const Colour& colour) {
  if (x < 0 || y < 0 || x >= width || y >= height) return;
  const std::size_t i =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  std::copy(colour.begin(), colour.end(), rgb.begin() + static_cast<std::ptrdiff_t>(i));
}

void Image::fill_rectangle(int x, int y, int rectangle_width, int rectangle_height, const Colour& colour) {
  for (int row = y; row < y + rectangle_height; ++row)
    for (int column = x; column < x + rectangle_width; ++column) set(column, row, colour);
}

void Image::paste(const Image& other, int x, int y) {
  for (int row = 0; row < other.height; ++row)
    for (int column = 0; column < other.width; ++column) set(x + column, y + row, other.at(column, row));
}

int text_width(std::string_view text, int size) {
  return text.empty() ? 0 : static_cast<int>(text.size()) * 6 * size - size;
}

void draw_text(Image& image, int x, int y, std::string_view text, int size, const Colour& colour) {
  for (char character : text) {
    const auto& glyph = glyph_of_character(character);
    for (int row = 0; row < 9; ++row)
      for (int column = 0; column < 5; ++column)
        if (glyph[static_cast<std::size_t>(row)] >> (4 - column) & 1)
          image.fill_rectangle(x + column * size, y + row * size, size, size, colour);
    x += 6 * size;
  }
}

void write_png(const std::filesystem::path& path, const Image& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  errno = 0;
  if (!png_image_write_to_file(&png, path.c_str(), 0, image.rgb.data(), 0, nullptr))
    throw CacheError(path.string() + ": cannot write the picture (" + (errno ? std::strerror(errno) : png.message) +
                     "); check the folder's permissions and free space");
}

Image read_png(const std::filesystem::path& path) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_file(&png, path.c_str()))
    throw InputError(path.string() + ": not a PNG picture (" + png.message + ")");
  png.format = PNG_FORMAT_RGB;
  Image image(static_cast<int>(png.width), static_cast<int>(png.height), {0, 0, 0});
  const png_color white{255, 255, 255};
  if (!png_image_finish_read(&png, &white, image.rgb.data(), 0, nullptr))
    throw InputError(path.string() + ": damaged PNG picture (" + png.message + ")");
  return image;
}

}  // namespace meshmser
