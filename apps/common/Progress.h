// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

namespace slalom::app
{
/// Progress on stderr: a bar on a terminal, one line per 10 % otherwise, nothing when quiet.
class Progress
{
 public:
  Progress(std::string what, bool quiet) : what_(std::move(what)), quiet_(quiet) {}
  ~Progress()
  {
    if (!quiet_ && terminal_ && shown_ >= 0) std::fputc('\n', stderr);
  }

  /// @param share done, in [0, 1]
  /// @param detail a few words behind the bar
  void show(double share, const std::string& detail = {})
  {
    const int percent = static_cast<int>(std::floor(100.0 * std::clamp(share, 0.0, 1.0)));
    const int step = terminal_ ? 1 : 10;
    if (quiet_ || percent / step == shown_) return;
    shown_ = percent / step;
    if (terminal_)
      std::fprintf(stderr, "\r%s [%-50s] %3d %% %s\033[K", what_.c_str(),
                   std::string(static_cast<std::size_t>(percent / 2), '#').c_str(), percent,
                   detail.c_str());
    else
      std::fprintf(stderr, "%s %3d %% %s\n", what_.c_str(), percent, detail.c_str());
  }

 private:
  std::string what_;
  bool quiet_;
  bool terminal_ = isatty(STDERR_FILENO) != 0;
  int shown_ = -1;
};

}  // namespace slalom::app
