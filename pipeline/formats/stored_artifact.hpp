#pragma once
/// The stored form of artifacts: numbers, words and lists in artifact.json, each array of numbers as one .npy file.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipeline/artifacts/artifact.hpp"

namespace meshmser {

/// One file of a stored artifact: header, then content. The content may lie in the artifact itself, which must outlive
/// this.
struct StoredFile {
  std::string name;
  std::string header;
  std::span<const std::byte> content;
  std::shared_ptr<const void> keep;  ///< owns the content where the artifact does not
};

/// The stored form of an artifact: artifact.json first, then arrays in the order of its fields. A list of flat records
/// (numbers and vectors only) is stored by columns. A FileSet's own files are not among them. Cost: records are copied,
/// arrays are not. The same artifact, the same bytes.
std::vector<StoredFile> stored_files(const Artifact& artifact);

/// A stored file as it is read back.
class StoredFileSource {
 public:
  virtual ~StoredFileSource() = default;
  virtual std::uint64_t size(const std::string& name) = 0;
  /// Fills `to` from `offset` on. May be called from several threads at once, for different files.
  virtual void read(const std::string& name, std::uint64_t offset, std::span<std::byte> to) = 0;
  /// Called with each file's whole content once it has been read, as header and rest.
  virtual void check(const std::string& name, std::span<const std::byte> header,
                     std::span<const std::byte> content) = 0;
};

/// Reads back an artifact of the type with index `type` (artifact_index). A FileSet gets `folder` as its folder.
/// Throws CacheError where the files are not what stored_files makes of that type, and what the source throws.
/// Arrays are read straight into place, several files at a time.
Artifact load_stored_artifact(std::size_t type, StoredFileSource& source, const std::filesystem::path& folder,
                              int threads = 0);

/// What `show` tells of one field.
struct FieldStatistics {
  std::string name;                    ///< path within the artifact: properties.0.values, regions.area
  std::string text;                    ///< of a single value, as it would be written; empty for an array
  std::vector<std::uint64_t> shape{};  ///< of an array
  std::string type{};                  ///< of an array's values, NumPy's name
  /// Of an array's finite values, each column apart: least, greatest, mean, and how many are not finite.
  struct Column {
    double least = 0, greatest = 0, mean = 0;
    std::uint64_t num_not_finite = 0;
    std::vector<std::uint64_t> histogram{};  ///< equal bins between least and greatest
  };
  std::vector<Column> columns{};
};

/// Every field of an artifact in order. O(size).
std::vector<FieldStatistics> field_statistics(const Artifact& artifact);

}  // namespace meshmser
