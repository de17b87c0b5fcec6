// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

namespace slalom::report
{
/// Something could not be written. The message names the path and says why (text of errno).
class OutputError : public std::runtime_error
{
 public:
  /// @param error_number errno of the failed call; 0 when `what` says it all
  OutputError(std::filesystem::path path, std::string_view what, int error_number = 0);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] int errorNumber() const { return error_number_; }

 private:
  std::filesystem::path path_;
  int error_number_;
};

/** A file that appears under its name only when it is complete.
 *
 *  Bytes go to NAME.part; commit() renames. A reader therefore never meets half a file, and an
 * earlier NAME stays intact until then. Without commit() (error, crash, abandoned run) what was
 * written stays in NAME.part. */
class AtomicFile
{
 public:
  /// @throws OutputError when NAME.part cannot be opened, or NAME is there and is not a regular
  /// file
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;

  /// Appends; buffered. @throws OutputError (full disk, ...); later writes throw again.
  void write(std::string_view bytes);

  /// Hands the buffer to the operating system. @throws OutputError
  void flush();

  /// Flushes, closes and renames. Second call: nothing. @throws OutputError; NAME.part then stays.
  void commit();

  /** After a failure: cuts NAME.part behind its last complete line and renames it, so that what was
   * written before the disk ran full is a readable file. Never throws. */
  void commitWholeLines() noexcept;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  [[noreturn]] void fail(std::string_view what);
  void closeQuietly() noexcept;

  std::filesystem::path path_, part_;
  int descriptor_ = -1;
  int error_number_ = 0;           ///< of the first failed write
  std::uint64_t whole_lines_ = 0;  ///< bytes on disk up to and with the last newline
  std::uint64_t bytes_on_disk_ = 0;
  std::string buffer_;
};

/// The whole content at once. @throws OutputError
void writeFileAtomically(const std::filesystem::path& path, std::string_view content);

}  // namespace slalom::report
