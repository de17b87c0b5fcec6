// SPDX-License-Identifier: BSD-3-Clause
#include "WorldFile.h"

#include <stdexcept>
#include <string>

#include "slalom/core/TextTable.h"
#include "slalom/mrpt_io/IniDocument.h"

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
    Eigen::Vector3d result;
    std::string_view rest = value.text;
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

Box readBox(Section& section)
{
  const Box box(section.triple("min"), section.triple("max"));
  if (!((box.max() - box.min()).minCoeff() > 0.0))
    section.fail(section.at("max"), "max", "is not above min on every axis");
  return box;
}
}  // namespace

WorldShapes readTrees(const std::filesystem::path& file)
{
  const std::vector<core::TextRow> rows = core::readRows(file, ',');
  const std::vector<std::string> header{"x", "y", "radius", "height"};
  if (rows.empty() || rows.front().fields != header)
    core::failAt(file, rows.empty() ? 1 : rows.front().line,
                 "the header must be x,y,radius,height");
  WorldShapes world;
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

WorldShapes readIniWorld(const std::filesystem::path& file)
{
  const IniDocument document = IniDocument::read(file);
  WorldShapes world;
  for (const std::string& name : document.sections())
  {
    Section section(document, name);
    const std::string kind = lowered(name.substr(0, name.find('.')));
    const bool named = name.find('.') != std::string::npos;
    if (kind == "tree" && named)
      world.trees.push_back(readTree(section));
    else if (kind == "box" && named)
      world.boxes.push_back(readBox(section));
    else if (kind == "world" && !named)
      world.ground = section.flag("ground", world.ground);
    else
      throw ConfigError(file.string() + ": unknown section [" + name +
                        "], a world has [tree.NAME], [box.NAME] and [world]");
    section.finish();
  }
  return world;
}

}  // namespace slalom::simulation::detail
