// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/tracking/MoverTracker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "Objects.h"
#include "RangeHistory.h"
#include "Track.h"

namespace slalom::tracking
{
namespace
{
using detail::Footprint;
using detail::Object;
using detail::Track;

constexpr std::size_t kMaxTracks = 128;
constexpr double kTentativeLife = 0.4;  // [s] unseen
constexpr double kStopTime = 0.5;       // [s] slow for this long is at rest
constexpr double kTransparent = 0.1;    // [1] a body lets fewer rays through
constexpr double kBodyMargin = 0.1;     // [m] around the seen body: noise of returns

struct CheckFields
{
  void operator()(const char* name, double& value, core::Range range, const char*,
                  core::Level = core::Level::Public) const
  {
    if (!(value >= range.min && value <= range.max))
      throw std::invalid_argument(
          std::string("[tracking] ") + name + " = " + std::to_string(value) + " must be in [" +
          std::to_string(range.min) + ", " + std::to_string(range.max) + "]");
  }
  void operator()(const char* name, int& value, core::Range range, const char* help,
                  core::Level = core::Level::Public) const
  {
    double real = value;
    (*this)(name, real, range, help);
  }
  void operator()(const char*, bool&, const char*, core::Level = core::Level::Public) const {}
};

TrackingConfig checked(TrackingConfig config)
{
  TrackingConfig::fields(config, CheckFields{});
  if (config.min_range_m >= config.range_m)
    throw std::invalid_argument("[tracking] range_m = " + std::to_string(config.range_m) +
                                " must exceed min_range_m = " + std::to_string(config.min_range_m));
  return config;
}

// An upright body as a stack of spheres.
void addGhosts(const Footprint& body, double margin, std::vector<core::Sphere>& ghosts)
{
  const double radius = body.half_width_m + margin;
  const double reach = std::max(0.0, body.half_height_m - body.half_width_m);
  const int steps = static_cast<int>(std::ceil(reach / std::max(0.1, 0.7 * radius)));
  for (int k = -steps; k <= steps; ++k)
    ghosts.push_back(
        {body.centre_L + Eigen::Vector3d(0, 0, steps > 0 ? reach * k / steps : 0.0), radius});
}

}  // namespace

struct MoverTracker::Impl
{
  explicit Impl(const TrackingConfig& c) : config(checked(c)), finder(config), history(config) {}

  [[nodiscard]] bool jumped(const std::vector<Object>& objects);
  void assign(const std::vector<Object>& objects);
  void watch(const std::vector<Object>& objects, const Eigen::Vector3f& origin_L,
             std::span<const core::Ray> rays, std::vector<core::Sphere>& ghosts);
  void recover(Track& track, const Eigen::Vector3f& origin_L, std::span<const core::Ray> rays,
               const core::DistanceField* map);
  void mark(const Track& track, std::span<const core::Ray> rays,
            std::vector<std::uint8_t>& on_mover) const;
  void settle();
  void openTracks(const std::vector<Object>& objects, std::span<const core::Ray> rays);

  TrackingConfig config;
  detail::ObjectFinder finder;
  detail::RangeHistory history;
  std::vector<Track> tracks;
  std::uint64_t next_id = 1;
  double t = -std::numeric_limits<double>::infinity();

  // Scratch of one update.
  struct Pair
  {
    double distance;
    int track, object;
  };
  std::vector<Pair> pairs;
  std::vector<int> object_of, track_of;  // or -1
  std::vector<std::uint32_t> body;
};

// Nearest pairs first; ties go to the older track, so the result does not depend on any sort.
void MoverTracker::Impl::assign(const std::vector<Object>& objects)
{
  object_of.assign(tracks.size(), -1);
  track_of.assign(objects.size(), -1);
  pairs.clear();
  for (std::size_t i = 0; i < tracks.size(); ++i)
    for (std::size_t j = 0; j < objects.size(); ++j)
    {
      const Eigen::Vector3d error = objects[j].centre_L - tracks[i].p_L;
      const double distance = error.head<2>().norm() + 0.3 * std::fabs(error.z());
      // A mover does not grow: it is one thing with something else now.
      if (tracks[i].confirmed && objects[j].half_width_m > tracks[i].largest_m) continue;
      if (distance <= tracks[i].gate())
        pairs.push_back({distance, static_cast<int>(i), static_cast<int>(j)});
    }
  std::sort(pairs.begin(), pairs.end(),
            [](const Pair& a, const Pair& b) {
              return std::tie(a.distance, a.track, a.object) <
                     std::tie(b.distance, b.track, b.object);
            });
  for (const Pair& pair : pairs)
  {
    int& object = object_of[static_cast<std::size_t>(pair.track)];
    int& track = track_of[static_cast<std::size_t>(pair.object)];
    if (object >= 0 || track >= 0) continue;
    object = pair.object;
    track = pair.track;
  }
}

// Whether most things are found off their places in one and the same direction: it is the estimate
// of the vehicle's own position that has moved.
bool MoverTracker::Impl::jumped(const std::vector<Object>& objects)
{
  constexpr std::size_t kEnough = 4;
  constexpr int kSettled = 4;     // footprints
  constexpr double kJump = 0.12;  // [m]
  std::vector<double> along[2];
  for (std::size_t i = 0; i < tracks.size(); ++i)
  {
    if (object_of[i] < 0 || tracks[i].footprints() < kSettled) continue;
    const Eigen::Vector3d off =
        objects[static_cast<std::size_t>(object_of[i])].centre_L - tracks[i].p_L;
    for (int axis = 0; axis < 2; ++axis) along[axis].push_back(off[axis]);
  }
  if (along[0].size() < kEnough) return false;
  double squared = 0.0;
  for (std::vector<double>& values : along)
  {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    squared += *middle * *middle;
  }
  return squared > kJump * kJump;
}

// Weighs the evidence of all tracks that were seen, and confirms.
void MoverTracker::Impl::watch(const std::vector<Object>& objects, const Eigen::Vector3f& origin_L,
                               std::span<const core::Ray> rays, std::vector<core::Sphere>& ghosts)
{
  int in_favour = 0, seen = 0;
  std::vector<int>& vote = object_of;  // becomes +1, 0 or -1
  for (std::size_t i = 0; i < tracks.size(); ++i)
  {
    Track& track = tracks[i];
    const int number = std::exchange(vote[i], 0);
    if (number < 0) continue;
    const Object& object = objects[static_cast<std::size_t>(number)];
    ++seen;
    if (track.fastEnough() || track.confirmed)
    {
      const std::optional<double> evidence = track.evidence(history, rays, object);
      if (evidence)
        vote[i] = *evidence >= config.evidence &&
                          detail::transparency(origin_L, rays, object) <= kTransparent
                      ? 1
                      : -1;
    }
    else
      vote[i] = -1;
    in_favour += vote[i] > 0 && !track.confirmed;
  }
  // Not everything moves: rather it is the vehicle's own position that has jumped.
  const bool all_moves = in_favour > 2 && 5 * in_favour > 2 * seen;
  for (std::size_t i = 0; i < tracks.size(); ++i)
  {
    Track& track = tracks[i];
    if (vote[i] > 0 && all_moves) vote[i] = 0;
    track.score = std::clamp(track.score + vote[i], 0, 2 * config.evidence_scans);
    const bool was = std::exchange(
        track.confirmed, track.confirmed ? track.score > 0 : track.score >= config.evidence_scans);
    if (!track.confirmed) continue;
    if (!was) track.last_fast = t, track.largest_m = 1.3 * track.half_width_m + kBodyMargin;
    // All of its way at first, then the last step: the map takes nothing more of it.
    constexpr double kLastStep = 0.25;  // [s]
    for (int age = 0; age < track.footprints(); ++age)
      if (!was || (age == 0 && t - track.footprint(age).t <= kLastStep))
        addGhosts(track.footprint(age), config.ghost_margin_m, ghosts);
  }
}

// A mover whose returns are one thing with something else, or too few: what lies where it is
// expected and is not known to be static is its own, since movers are kept out of the map.
void MoverTracker::Impl::recover(Track& track, const Eigen::Vector3f& origin_L,
                                 std::span<const core::Ray> rays, const core::DistanceField* map)
{
  const double width = track.half_width_m + 0.5 * track.gate();
  const double height = track.half_height_m + kBodyMargin;
  body.clear();
  for (std::uint32_t i = 0; i < rays.size(); ++i)
  {
    const Eigen::Vector3d d = rays[i].end_L.cast<double>() - track.p_L;
    if (!(d.head<2>().squaredNorm() <= width * width && std::fabs(d.z()) <= height)) continue;
    const auto distance =
        map ? map->distance(rays[i].end_L.cast<double>(), core::UnknownAs::Free) : std::nullopt;
    if (!distance || *distance > 0.5 * map->resolution()) body.push_back(i);
  }
  if (map == nullptr || body.size() < static_cast<std::size_t>(config.min_points)) return;
  const Object object = detail::fitObject(origin_L, rays, body);
  const double off = (object.centre_L - track.p_L).head<2>().norm();
  if (off > track.gate() || object.half_width_m > track.largest_m) return;
  track.correct(object, (object.centre_L - origin_L.cast<double>()).norm());
}

void MoverTracker::Impl::mark(const Track& track, std::span<const core::Ray> rays,
                              std::vector<std::uint8_t>& on_mover) const
{
  const double width = track.half_width_m + kBodyMargin;
  const double height = track.half_height_m + 2.0 * kBodyMargin;
  for (std::size_t i = 0; i < rays.size(); ++i)
  {
    const Eigen::Vector3d d = rays[i].end_L.cast<double>() - track.p_L;
    if (d.head<2>().squaredNorm() <= width * width && std::fabs(d.z()) <= height) on_mover[i] = 1;
  }
}

// What has come to rest is not a mover any more; what has not been seen for long is gone.
void MoverTracker::Impl::settle()
{
  for (Track& track : tracks)
  {
    if (track.speed() >= 0.5 * config.min_speed_mps) track.last_fast = t;
    if (track.confirmed && t - track.last_fast > kStopTime)
      track.confirmed = false, track.score = 0;
  }
  std::erase_if(tracks, [&](const Track& track)
                { return t - track.seen > (track.confirmed ? config.coast_s : kTentativeLife); });
}

void MoverTracker::Impl::openTracks(const std::vector<Object>& objects,
                                    std::span<const core::Ray> rays)
{
  for (std::size_t j = 0; j < objects.size() && tracks.size() < kMaxTracks; ++j)
  {
    if (track_of[j] >= 0) continue;
    tracks.emplace_back(next_id++, config, t, objects[j]);
    tracks.back().remember(rays, objects[j]);
  }
}

MoverTracker::MoverTracker(const TrackingConfig& config) : impl_(std::make_unique<Impl>(config)) {}
MoverTracker::~MoverTracker() = default;
MoverTracker::MoverTracker(MoverTracker&&) noexcept = default;
MoverTracker& MoverTracker::operator=(MoverTracker&&) noexcept = default;

TrackerOutput MoverTracker::update(double t, const Eigen::Vector3d& p_L,
                                   std::span<const core::Ray> rays, const core::DistanceField* map)
{
  Impl& m = *impl_;
  TrackerOutput out;
  out.on_mover.assign(rays.size(), 0);
  if (!m.config.enabled || !std::isfinite(t) || !p_L.allFinite() || !(t > m.t)) return out;
  m.t = t;
  // Panoramas are seen from the middle of the scan's path.
  Eigen::Vector3f origin_L = p_L.cast<float>();
  if (!rays.empty() && rays[rays.size() / 2].origin_L.allFinite())
    origin_L = rays[rays.size() / 2].origin_L;

  m.history.add(t, origin_L, rays);
  const std::vector<Object>& objects = m.finder.find(origin_L, rays);
  out.objects = static_cast<int>(objects.size());
  for (Track& track : m.tracks) track.predict(t);
  m.assign(objects);
  if (m.jumped(objects))
  {
    // What was seen before cannot be compared with what is seen now.
    std::erase_if(m.tracks, [](const Track& track) { return !track.confirmed; });
    m.history.clear();
    m.history.add(t, origin_L, rays);
    m.assign(objects);
  }
  for (std::size_t i = 0; i < m.tracks.size(); ++i)
  {
    if (m.object_of[i] >= 0)
    {
      const Object& object = objects[static_cast<std::size_t>(m.object_of[i])];
      m.tracks[i].correct(object, (object.centre_L - origin_L.cast<double>()).norm());
    }
    else if (m.tracks[i].confirmed)
      m.recover(m.tracks[i], origin_L, rays, map);
  }
  const std::vector<int> assigned = m.object_of;
  m.watch(objects, origin_L, rays, out.ghosts);
  for (std::size_t i = 0; i < m.tracks.size(); ++i)
  {
    Track& track = m.tracks[i];
    const Object* object =
        assigned[i] >= 0 ? &objects[static_cast<std::size_t>(assigned[i])] : nullptr;
    if (object != nullptr) track.remember(rays, *object);
    if (!track.confirmed && track.score + 1 < m.config.evidence_scans) continue;
    m.mark(track, rays, out.on_mover);
    for (const std::uint32_t ray : object ? object->rays : std::span<const std::uint32_t>{})
      out.on_mover[ray] = 1;
  }
  m.settle();
  m.openTracks(objects, rays);
  out.movers = at(t);
  return out;
}

std::vector<core::MovingObstacle> MoverTracker::at(double t) const
{
  std::vector<core::MovingObstacle> movers;
  for (const Track& track : impl_->tracks)
    if (track.confirmed && t - track.seen <= impl_->config.coast_s) movers.push_back(track.at(t));
  return movers;
}

void MoverTracker::reset()
{
  impl_->tracks.clear();
  impl_->history.clear();
  impl_->t = -std::numeric_limits<double>::infinity();
}

}  // namespace slalom::tracking
