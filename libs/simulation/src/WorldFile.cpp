// SPDX-License-Identifier: BSD-3-Clause
#include "WorldFile.h"

#include <stdexcept>
#include <string>

#include "slalom/core/Rng.h"
#include "slalom/core/TextTable.h"
#include "slalom/mrpt_io/IniDocument.h"
#include "slalom/simulation/FlightRecorder.h"

namespace slalom::simulation::detail
{
namespace
{
using mrpt_io::ConfigError;
using mrpt_io::IniDocument;

std::string lowered(std::string text)
{
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

/// Takes the keys of one section by name and complains about those that nobody took.
class Section
{
 public:
  Section(const IniDocument& document, const std::string& name) : document_(document), name_(name)
  {
    for (const std::string& key : document.keys(name)) left_.push_back(lowered(key));
  }

  double number(const std::string& key)
  {
    const IniDocument::Value& value = take(key);
    const std::optional<double> parsed = core::parseNumber(value.text);
    if (!parsed) fail(value, key, "is not a finite number");
    return *parsed;
  }
  double positive(const std::string& key)
  {
    const double value = number(key);
    if (!(value > 0.0)) fail(*document_.find(name_, key), key, "must be > 0");
    return value;
  }
  Eigen::Vector3d triple(const std::string& key)
  {
    const IniDocument::Value& value = take(key);
    return parsedTriple(value, key, value.text);
  }
  /// Triples with '|' between them (';' would begin a comment).
  std::vector<Eigen::Vector3d> triples(const std::string& key)
  {
    const IniDocument::Value& value = take(key);
    std::vector<Eigen::Vector3d> result;
    for (std::string_view rest = value.text; !rest.empty();)
    {
      const std::size_t end = std::min(rest.find('|'), rest.size());
      result.push_back(parsedTriple(value, key, rest.substr(0, end)));
      rest = rest.substr(std::min(end + 1, rest.size()));
    }
    return result;
  }
  [[nodiscard]] bool has(const std::string& key) const { return document_.find(name_, key); }
  double number(const std::string& key, double otherwise)
  {
    return has(key) ? number(key) : otherwise;
  }
  std::string word(const std::string& key) { return lowered(take(key).text); }
  bool flag(const std::string& key, bool otherwise)
  {
    if (!document_.find(name_, key)) return otherwise;
    const IniDocument::Value& value = take(key);
    const std::string text = lowered(value.text);
    if (text != "true" && text != "false") fail(value, key, "is neither true nor false");
    return text == "true";
  }
  void finish() const
  {
    if (left_.empty()) return;
    const IniDocument::Value& value = *document_.find(name_, left_.front());
    throw ConfigError(value.origin + ": [" + name_ + "] has an unknown key '" + left_.front() +
                      "'");
  }
  [[noreturn]] void fail(const IniDocument::Value& value, const std::string& key,
                         const std::string& what) const
  {
    throw ConfigError(value.origin + ": [" + name_ + "] " + key + " = " + value.text + " " + what);
  }
  [[nodiscard]] const IniDocument::Value& at(const std::string& key) const
  {
    return *document_.find(name_, key);
  }

 private:
  Eigen::Vector3d parsedTriple(const IniDocument::Value& value, const std::string& key,
                               std::string_view rest) const
  {
    Eigen::Vector3d result;
    for (int i = 0; i < 3; ++i)
    {
      const std::size_t comma = rest.find(',');
      if ((comma == std::string_view::npos) != (i == 2)) fail(value, key, "is not x,y,z");
      const std::optional<double> parsed = core::parseNumber(core::trimmed(rest.substr(0, comma)));
      if (!parsed) fail(value, key, "is not x,y,z with finite numbers");
      result[i] = *parsed;
      rest = i == 2 ? rest : rest.substr(comma + 1);
    }
    return result;
  }
  const IniDocument::Value& take(const std::string& key)
  {
    const IniDocument::Value* value = document_.find(name_, key);
    if (!value) throw ConfigError(where() + ": [" + name_ + "] lacks the key '" + key + "'");
    std::erase(left_, key);
    return *value;
  }
  std::string where() const
  {
    const std::vector<std::string> keys = document_.keys(name_);
    return keys.empty() ? "world" : document_.find(name_, keys.front())->origin;
  }

  const IniDocument& document_;
  std::string name_;
  std::vector<std::string> left_;
};

Tree readTree(Section& section)
{
  Tree tree;
  tree.centre_W = {section.number("x"), section.number("y")};
  tree.radius = section.positive("radius");
  tree.height = section.positive("height");
  return tree;
}

Tree readCylinder(Section& section)
{
  Tree cylinder = readTree(section);
  cylinder.base = section.number("base", 0.0);
  return cylinder;
}

Sphere readSphere(Section& section)
{
  return {section.triple("centre"), section.positive("radius")};
}

AtEnd readAtEnd(Section& section)
{
  const std::string word = section.word("at_end");
  if (word == "stop") return AtEnd::Stop;
  if (word == "return") return AtEnd::Return;
  if (word == "loop") return AtEnd::Loop;
  section.fail(section.at("at_end"), "at_end", "is none of stop, return, loop");
}

void readWaypoints(Section& section, MoverPath& path)
{
  path.waypoints_W = section.triples("waypoints");
  if (path.waypoints_W.size() < 2)
    section.fail(section.at("waypoints"), "waypoints", "needs two points or more");
  path.speed = section.positive("speed");
  if (section.has("at_end")) path.at_end = readAtEnd(section);
}

void readFormula(Section& section, MoverPath& path)
{
  path.start_W = section.triple("start");
  if (section.has("velocity")) path.velocity_W = section.triple("velocity");
  if (!section.has("amplitude")) return;
  path.amplitude_W = section.triple("amplitude");
  path.period_s = section.positive("period_s");
  path.phase = section.number("phase_rad", 0.0);
}

Mover readMover(Section& section, const std::string& name, std::uint64_t seed)
{
  Mover mover;
  mover.name = name;
  mover.radius = section.positive("radius");
  if (section.has("height")) mover.height = section.positive("height");
  if (section.has("waypoints"))
    readWaypoints(section, mover.path);
  else
    readFormula(section, mover.path);
  mover.path.delay_s = section.number("delay_s", 0.0);
  // A stream of its own, so that one mover does not change another's jitter.
  if (section.has("jitter_s"))
    mover.path.delay_s +=
        core::Rng(streamSeed(seed, name)).uniform(-1.0, 1.0) * section.positive("jitter_s");
  return mover;
}

Box readBox(Section& section)
{
  const Box box(section.triple("min"), section.triple("max"));
  if (!((box.max() - box.min()).minCoeff() > 0.0))
    section.fail(section.at("max"), "max", "is not above min on every axis");
  return box;
}
}  // namespace

Shapes readTrees(const std::filesystem::path& file)
{
  const std::vector<core::TextRow> rows = core::readRows(file, ',');
  const std::vector<std::string> header{"x", "y", "radius", "height"};
  if (rows.empty() || rows.front().fields != header)
    core::failAt(file, rows.empty() ? 1 : rows.front().line,
                 "the header must be x,y,radius,height");
  Shapes world;
  for (std::size_t k = 1; k < rows.size(); ++k)
  {
    const core::TextRow& row = rows[k];
    if (row.fields.size() != 4)
      core::failAt(file, row.line,
                   std::to_string(row.fields.size()) + " fields where 4 are needed");
    Tree tree;
    tree.centre_W = {core::numberAt(file, row, 0), core::numberAt(file, row, 1)};
    tree.radius = core::numberAt(file, row, 2);
    tree.height = core::numberAt(file, row, 3);
    for (const std::size_t field : {2u, 3u})
      if (!(core::numberAt(file, row, field) > 0.0))
        core::failAt(file, row.line, header[field] + " = " + row.fields[field] + " must be > 0");
    world.trees.push_back(tree);
  }
  return world;
}

Shapes readIniWorld(const std::filesystem::path& file, std::uint64_t seed)
{
  const IniDocument document = IniDocument::read(file);
  Shapes world;
  for (const std::string& name : document.sections())
  {
    Section section(document, name);
    const std::string kind = lowered(name.substr(0, name.find('.')));
    const bool named = name.find('.') != std::string::npos;
    if (kind == "tree" && named)
      world.trees.push_back(readTree(section));
    else if (kind == "box" && named)
      world.boxes.push_back(readBox(section));
    else if (kind == "cylinder" && named)
      world.trees.push_back(readCylinder(section));
    else if (kind == "sphere" && named)
      world.spheres.push_back(readSphere(section));
    else if (kind == "mover" && named)
      world.movers.push_back(readMover(section, name.substr(name.find('.') + 1), seed));
    else if (kind == "world" && !named)
      world.ground = section.flag("ground", world.ground);
    else
      throw ConfigError(file.string() + ": unknown section [" + name +
                        "], a world has [tree.NAME], [cylinder.NAME], [box.NAME], [sphere.NAME], "
                        "[mover.NAME] and [world]");
    section.finish();
  }
  return world;
}

}  // namespace slalom::simulation::detail
