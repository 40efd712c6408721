#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <random>

#include "pipeline/formats/geometry_file.hpp"
#include "pipeline/formats/stanford_conf.hpp"

namespace meshmser {
namespace {

template <class... Numbers>
std::string packed(Numbers... numbers) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&numbers), sizeof(numbers)), ...);
  return bytes;
}

struct Sample {
  std::string name, content;
};

/// One small good file of each kind.
std::vector<Sample> samples() {
  const std::string ply_head =
      " 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  std::string points;
  for (int i = 0; i < 3; ++i)
    points += packed(static_cast<float>(i), 1.f, static_cast<float>(i * i), static_cast<std::uint8_t>(7));
  const std::string face = packed(std::uint8_t{3}, 0, 1, 2);
  const std::string pcd_head =
      "VERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 "
      "0 0\nPOINTS 2\nDATA ";
  std::string values;
  for (int i = 0; i < 8; ++i) values += packed(static_cast<float>(i));
  return {{"a.ply", "ply\nformat ascii" + ply_head + "0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2\n"},
          {"b.ply", "ply\nformat binary_little_endian" + ply_head + points + face},
          {"c.ply", "ply\nformat binary_big_endian" + ply_head + std::string(39, 1) +
                        std::string("\3\0\0\0\0\0\0\0\1\0\0\0\2", 13)},
          {"a.xyz", "# x y z i\n1 2 3 4\n5 6 7 8\n-1e3 .5 nan 9\n"},
          {"a.csv", "x;y;z\n1;2;3\n4;5;6\n"},
          {"a.pts", "2\n1 2 3 4 5 6 7\n1 2 4 4 5 6 7\n"},
          {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
          {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/1 -1/1\n"},
          {"a.stl",
           "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
           "0\nendloop\nendfacet\nendsolid\n"},
          {"b.stl", std::string(80, 'h') + packed(1u) + std::string(50, '\x3f')},
          {"a.ptx", "1\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n0 0 0 0.5\n"},
          {"a.pcd", pcd_head + "ascii\n1 2 3 4\n5 6 7 8\n"},
          {"b.pcd", pcd_head + "binary\n" + values},
          {"c.pcd", pcd_head + "binary_compressed\n" + packed(33u, 32u, std::uint8_t{31}) + values},
          {"a.conf", "camera 0 0 0 0 0 0 1\nbmesh a.ply 1 2 3 0 0 0 1\n"}};
}

void read(const std::string& name, const std::string& content) {
  auto data = std::make_unique<char[]>(content.size() + 1);
  std::copy(content.begin(), content.end(), data.get());
  const FileBytes file(name, std::move(data), content.size());
  if (name.ends_with(".conf")) {
    read_stanford_conf(file);
  } else {
    read_geometry(file);
  }
}

std::string mutated(std::string text, std::mt19937& random) {
  static const std::array<std::string, 12> kWords{"-1",
                                                  "4294967295",
                                                  "99999999999999999999",
                                                  "nan",
                                                  "1e999",
                                                  "\n",
                                                  " ",
                                                  "0",
                                                  std::string(1, '\0'),
                                                  "list",
                                                  "\xff\xff\xff\xff",
                                                  ","};
  const int changes = 1 + static_cast<int>(random() % 3);
  for (int i = 0; i < changes && !text.empty(); ++i) {
    const std::size_t at = random() % text.size();
    switch (random() % 5) {
      case 0:
        text[at] = static_cast<char>(random() % 256);
        break;
      case 1:
        text.resize(at);
        break;
      case 2:
        text.erase(at, 1 + random() % 8);
        break;
      case 3:
        text.insert(at, kWords[random() % kWords.size()]);
        break;
      default:
        text.insert(at, text.substr(random() % text.size(), random() % 16));
    }
  }
  return text;
}

TEST(Mutation, GoodSamplesAreRead) {
  for (const Sample& sample : samples()) EXPECT_NO_THROW(read(sample.name, sample.content)) << sample.name;
}

TEST(Mutation, DamagedFilesAreReadOrRefusedButNothingElse) {
  int refused = 0;
  for (const Sample& sample : samples())
    for (unsigned seed = 0; seed < 400; ++seed) {
      std::mt19937 random(seed);
      try {
        read(sample.name, mutated(sample.content, random));
      } catch (const InputError& error) {
        ++refused;
        EXPECT_TRUE(std::string(error.what()).starts_with(sample.name)) << error.what();
      } catch (const std::exception& error) {
        ADD_FAILURE() << sample.name << " seed " << seed << ": " << error.what();
      }
    }
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace meshmser
