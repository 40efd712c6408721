#pragma once
/// The closed list of ways in which meshmser fails, each with its exit code.

#include <stdexcept>
#include <string>

namespace meshmser {

enum class ExitCode { kOk = 0, kInternal = 1, kUsage = 2, kConfig = 3, kInput = 4, kStage = 5, kCache = 6, kInterrupted = 130 };

/// What every error of ours is. `what()` is a whole message for the user: the file, line or element, what was
/// expected, and what to do.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

/// The command line cannot be understood.
struct UsageError : Error {
  explicit UsageError(const std::string& message) : Error(ExitCode::kUsage, message) {}
};
/// The configuration cannot be used; the message may hold several diagnostics, one after the other.
struct ConfigError : Error {
  explicit ConfigError(const std::string& message) : Error(ExitCode::kConfig, message) {}
};
/// An input file cannot be read; the message begins with file:line or file.
struct InputError : Error {
  explicit InputError(const std::string& message) : Error(ExitCode::kInput, message) {}
};
/// A stage cannot do its work on data that were read without error.
struct StageError : Error {
  explicit StageError(const std::string& message) : Error(ExitCode::kStage, message) {}
};
/// The cache or the disk failed.
struct CacheError : Error {
  explicit CacheError(const std::string& message) : Error(ExitCode::kCache, message) {}
};
/// The user asked to stop.
struct Cancelled : Error {
  Cancelled() : Error(ExitCode::kInterrupted, "interrupted") {}
};

}  // namespace meshmser
