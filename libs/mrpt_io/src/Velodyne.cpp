// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/mrpt_io/Velodyne.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#include "VelodyneModel.h"

namespace slalom::mrpt_io
{
namespace
{
static_assert(std::endian::native == std::endian::little, "packets are read as they lie in memory");
static_assert(sizeof(VelodynePacket) ==
              sizeof(mrpt::obs::CObservationVelodyneScan::TVelodyneRawPacket));

constexpr int kTurn = 36000;                 // [0.01 deg]
constexpr int kWidestGap = 200;              // [0.01 deg] per block: beyond 20 Hz, not a rotation
constexpr std::uint32_t kHour = 3600000000;  // [us]
constexpr double kPacketGap = 0.5;           // [s] longer ones are a broken clock
constexpr std::uint16_t kUpper = 0xEEFF, kLower = 0xDDFF;

struct Direction
{
  float sine, cosine;
};

const std::vector<Direction>& directions()
{
  static const std::vector<Direction> table = []
  {
    std::vector<Direction> t(kTurn);
    for (int i = 0; i < kTurn; ++i)
    {
      const double angle = i * 2.0 * std::numbers::pi / kTurn;
      t[static_cast<std::size_t>(i)] = {static_cast<float>(std::sin(angle)),
                                        static_cast<float>(std::cos(angle))};
    }
    return t;
  }();
  return table;
}

std::size_t wrapped(int azimuth)
{
  if (azimuth >= kTurn) return static_cast<std::size_t>(azimuth - kTurn);
  return static_cast<std::size_t>(azimuth < 0 ? azimuth + kTurn : azimuth);
}

struct Tally
{
  std::uint64_t zero = 0, header = 0, range = 0, model = 0, calibration = 0;
};

/// Decodes packet by packet; what changes from packet to packet is the clock alone.
class Decoder
{
 public:
  Decoder(const mrpt::obs::CObservationVelodyneScan& scan, core::RangeScan& out, Tally& tally)
      : models_(scan.calibration),
        max_range_(static_cast<float>(scan.maxRange > 0.0 ? scan.maxRange : 1e3)),
        out_(out),
        tally_(tally)
  {
  }

  void packet(const VelodynePacket& p)
  {
    const detail::SensorModel* model = models_.of(p);
    if (!model)
    {
      (detail::SensorModels::isHdl64(p) ? tally_.calibration : tally_.model) +=
          VelodynePacket::kBlocks * VelodynePacket::kReturnsPerBlock;
      return;
    }
    const int group = model->two_banks || p.return_mode == VelodynePacket::kDual ? 2 : 1;
    advanceClock(p, *model, group);
    int gap = 0;
    for (int b = 0; b < VelodynePacket::kBlocks; b += group)
    {
      // The last block has no successor; the sensor turned on at the same rate.
      if (b + group < VelodynePacket::kBlocks)
        gap = gapBetween(p.blocks[b], p.blocks[b + group], gap);
      const double start = clock_ + (b / group) * model->block_period;
      for (int i = 0; i < group; ++i)
      {
        const VelodynePacket::Block* first = i > 0 && !model->two_banks ? &p.blocks[b] : nullptr;
        block(p.blocks[b + i], first, *model, start, gap);
      }
    }
  }

  [[nodiscard]] double last() const { return last_; }

 private:
  void advanceClock(const VelodynePacket& p, const detail::SensorModel& model, int group)
  {
    if (started_)
    {
      const std::uint32_t elapsed = (p.microseconds % kHour + kHour - before_) % kHour;
      const double seconds = 1e-6 * elapsed;
      // A clock that stands still or jumps is replaced by the sensor's nominal rate.
      const bool believable = elapsed > 0 && seconds < kPacketGap;
      clock_ += believable ? seconds : VelodynePacket::kBlocks / group * model.block_period;
    }
    started_ = true;
    before_ = p.microseconds % kHour;
  }

  static int gapBetween(const VelodynePacket::Block& a, const VelodynePacket::Block& b, int before)
  {
    const int gap = (b.azimuth - a.azimuth + kTurn) % kTurn;
    return gap <= kWidestGap ? gap : before;
  }

  /// @param first the first return of the same firing in dual mode, else nullptr
  void block(const VelodynePacket::Block& block, const VelodynePacket::Block* first,
             const detail::SensorModel& model, double start, int gap)
  {
    const bool lower = block.header == kLower && model.two_banks;
    if ((block.header != kUpper && !lower) || block.azimuth >= kTurn)
    {
      tally_.header += VelodynePacket::kReturnsPerBlock;
      return;
    }
    const detail::Laser* lasers = model.lasers.data() + (lower ? 32 : 0);
    for (int i = 0; i < VelodynePacket::kReturnsPerBlock; ++i)
    {
      const std::uint16_t distance = block.returns[i].distance;
      if (distance == 0)
      {
        ++tally_.zero;
        if (first) continue;
      }
      if (first && distance == first->returns[i].distance) continue;
      const detail::Slot& slot = model.slots[static_cast<std::size_t>(i)];
      const int turned = (gap * slot.turn_q16 + (1 << 15)) >> 16;
      const int azimuth = block.azimuth + turned;
      Silence& silence = silences_[(lower ? 32U : 0U) + static_cast<std::size_t>(slot.laser)];
      if (distance == 0)
        listen(silence, lasers[slot.laser], azimuth, start + slot.after);
      else
      {
        silence.length = 0;
        point(distance, lasers[slot.laser], azimuth, start + slot.after);
      }
    }
  }

  /// The last firings of one laser, all without an echo.
  struct Silence
  {
    std::array<core::ScanPoint, 3> last;
    int length = 0;
  };

  /// Now and then an echo is lost: only a silence that lasts says that nothing is there. The firing
  /// in the middle of five is told.
  void listen(Silence& silence, const detail::Laser& laser, int azimuth, double time)
  {
    constexpr int kLasting = 5;
    const Direction& d = table_[wrapped(azimuth - laser.azimuth_offset)];
    const auto at = static_cast<std::size_t>(silence.length % 3);
    silence.last[at] = {
        {laser.cos_elevation * d.cosine, -laser.cos_elevation * d.sine, laser.sin_elevation},
        static_cast<float>(time)};
    if (++silence.length >= kLasting) out_.silent.push_back(silence.last[(at + 1) % 3]);
  }

  void point(std::uint16_t distance, const detail::Laser& laser, int azimuth, double time)
  {
    const float r =
        static_cast<float>(distance * VelodynePacket::kDistanceUnit) + laser.distance_offset;
    if (r <= 0.0f || r > max_range_)
    {
      ++tally_.range;
      return;
    }
    const Direction& d = table_[wrapped(azimuth - laser.azimuth_offset)];
    const float flat = r * laser.cos_elevation - laser.vertical_offset * laser.sin_elevation;
    core::ScanPoint& p = out_.points.emplace_back();
    p.p_S = {flat * d.cosine + laser.horizontal_offset * d.sine,
             -flat * d.sine + laser.horizontal_offset * d.cosine,
             r * laser.sin_elevation + laser.vertical_offset * laser.cos_elevation};
    p.dt = static_cast<float>(time);
    last_ = std::max(last_, time);
  }

  detail::SensorModels models_;
  const std::vector<Direction>& table_ = directions();
  std::array<Silence, 64> silences_;
  float max_range_;
  core::RangeScan& out_;
  Tally& tally_;
  bool started_ = false;
  std::uint32_t before_ = 0;
  double clock_ = 0.0, last_ = 0.0;
};
}  // namespace

void decodeVelodyne(const mrpt::obs::CObservationVelodyneScan& scan, core::RangeScan& out,
                    std::map<std::string, std::uint64_t>& dropped)
{
  out.points.clear();
  out.silent.clear();
  out.points.reserve(scan.scan_packets.size() * VelodynePacket::kBlocks *
                     VelodynePacket::kReturnsPerBlock);
  Tally tally;
  Decoder decoder(scan, out, tally);
  VelodynePacket packet;
  for (const auto& raw : scan.scan_packets)
  {
    std::memcpy(&packet, &raw, sizeof(packet));
    decoder.packet(packet);
  }
  out.duration = decoder.last();
  const std::pair<const char*, std::uint64_t> reasons[] = {
      {"zero range", tally.zero},
      {"bad block header", tally.header},
      {"out of range", tally.range},
      {"unknown model", tally.model},
      {"HDL-64 without calibration", tally.calibration}};
  for (const auto& [reason, count] : reasons)
    if (count > 0) dropped[reason] += count;
}

}  // namespace slalom::mrpt_io
