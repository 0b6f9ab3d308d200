// SPDX-License-Identifier: Apache-2.0
#include "tools/synth/sweep/sweep_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "calib/base/fields/slots.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/number_text.h"
#include "calib/base/statistics/random.h"
#include "machine/config/machine_file.h"
#include "machine/config/toml/ranges.h"
#include "machine/config/toml/toml_table.h"
#include <fmt/format.h>

namespace panelcal::synth {
namespace {

using internal::count;
using internal::field;
using internal::Field;
using internal::FieldKind;
using internal::FileDescription;
using internal::kMaxToolNumber;
using internal::Range;
using internal::Rows;
using internal::Table;
using internal::TableDescription;
using internal::TomlSource;
using internal::TomlTable;
using internal::word;

constexpr std::size_t kMaxSweepBytes = std::size_t{1} << 20;

struct SweepKeys {
  std::filesystem::path machine;
  std::filesystem::path program;
  std::optional<int> tool;
  int n_pictures = 1;
  Design design = Design::Grid;
  std::optional<std::int64_t> n_points;
  int n_repeats = 1;
  std::uint64_t seed = 1;
};

struct FactorKeys {
  std::string key;
  std::string column;
  std::optional<double> from;
  std::optional<double> to;
  int n_levels = 0;
  bool is_log = false;
  std::vector<double> values;
};

std::optional<bool> is_log_of(std::string_view text) {
  if (text == "log") return true;
  return text == "linear" ? std::optional(false) : std::nullopt;
}

#include "tools/synth/sweep/sweep_file.def"

/// Where a factor's number stands in machine.toml.
struct SimKey {
  std::string_view table;  ///< "sim.debris"
  const Field* field = nullptr;
  std::optional<std::size_t> i_component;  ///< of a pair
};

struct NamedKey {
  std::string name;  ///< as a sweep file has it
  SimKey key;
};

/// Every number of [sim] and of the tables in it.
std::vector<NamedKey> sim_keys() {
  std::vector<NamedKey> out;
  const FileDescription file = internal::machine_file();
  for (const TableDescription* const table : file.tables) {
    const bool is_sim = table->name == "sim" || table->name.starts_with("sim.");
    if (!is_sim || table->rows == Rows::Many) continue;
    const std::string prefix = table->name == "sim" ? "" : std::string(table->name.substr(4)) + ".";
    for (const Field& one : table->fields) {
      const std::string name = prefix + std::string(one.key);
      if (one.kind == FieldKind::Number || one.kind == FieldKind::Whole) {
        out.push_back({name, {table->name, &one, std::nullopt}});
      } else if (one.kind == FieldKind::Pair) {
        out.push_back({name + ".x", {table->name, &one, 0}});
        out.push_back({name + ".y", {table->name, &one, 1}});
      }
    }
  }
  return out;
}

std::optional<SimKey> sim_key(std::string_view name) {
  for (const NamedKey& one : sim_keys()) {
    if (one.name == name) return one.key;
  }
  return std::nullopt;
}

Diagnostic unknown_factor(const TomlTable& table, const std::string& key) {
  const std::vector<NamedKey> keys = sim_keys();
  std::vector<std::string_view> names;
  for (const NamedKey& one : keys) names.push_back(one.name);
  const std::string_view near = nearest_word(key, names);
  return table.problem("key",
                       near.empty() ? "a number of [sim], such as noise or debris.rim_share"
                                    : "did you mean " + quoted(near) + "?",
                       "[sim] has no such number");
}

Expected<void> check_kind_of_values(const TomlTable& table, const FactorKeys& keys) {
  if (table.has("values")) {
    for (const std::string_view key : {"from", "to", "levels", "scale"}) {
      if (table.has(key)) {
        return failure(table.problem(key, "a range, or values", "values are there already"));
      }
    }
    if (keys.values.empty()) return failure(table.problem("values", "one value or more"));
    return {};
  }
  for (const std::string_view key : {"from", "to"}) {
    if (!table.has(key)) return failure(table.missing(key, "from and to, or values"));
  }
  if (!(*keys.from < *keys.to)) return failure(table.problem("to", "a number above from"));
  if (keys.is_log && !(*keys.from > 0)) {
    return failure(table.problem("from", "a number above 0, of which there are ratios"));
  }
  return {};
}

Expected<void> check_values(const TomlTable& table, const Factor& factor, const Field& field) {
  std::vector<std::pair<std::string_view, double>> all;
  for (const double value : factor.values) all.emplace_back("values", value);
  if (factor.values.empty()) all = {{"from", *factor.from}, {"to", *factor.to}};
  for (const auto& [key, value] : all) {
    const bool is_taken = factor.is_whole
                              ? value == std::floor(value) && std::abs(value) <= 0x1p53 &&
                                    field.whole.contains(static_cast<std::int64_t>(value))
                              : field.range.contains(value);
    if (is_taken) continue;
    return failure(table.problem(
        key, factor.is_whole ? field.whole.text() : field.range.text(), "for " + factor.key));
  }
  return {};
}

Expected<std::string> column_of(const TomlTable& table, const FactorKeys& keys) {
  std::string column = keys.column.empty() ? keys.key : keys.column;
  if (keys.column.empty()) std::ranges::replace(column, '.', '_');
  const bool is_name = std::ranges::all_of(column, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
  if (is_name && !(column.front() >= '0' && column.front() <= '9')) return column;
  return failure(
      table.problem("column", "a name of letters, digits and _ that begins with no digit"));
}

Expected<Factor> read_factor(const TomlTable& table) {
  FactorKeys keys;
  PANELCAL_CHECK(table.read(kFactor, keys));
  const std::optional<SimKey> where = sim_key(keys.key);
  if (!where) return failure(unknown_factor(table, keys.key));
  PANELCAL_CHECK(check_kind_of_values(table, keys));
  PANELCAL_TRY(std::string column, column_of(table, keys));
  Factor factor{keys.key,
                std::move(column),
                keys.from,
                keys.to,
                std::move(keys.values),
                keys.n_levels,
                keys.is_log,
                where->field->kind == FieldKind::Whole};
  PANELCAL_CHECK(check_values(table, factor, *where->field));
  return factor;
}

Expected<std::vector<Factor>> read_factors(const TomlTable& top) {
  PANELCAL_TRY(const auto tables, top.tables(kFactor));
  std::vector<Factor> out;
  for (const TomlTable& table : tables) {
    PANELCAL_TRY(Factor factor, read_factor(table));
    const auto is_like = [&](const Factor& other) {
      return other.key == factor.key || other.column == factor.column;
    };
    if (std::ranges::any_of(out, is_like)) {
      return failure(table.problem("key", "one of its own", "another factor has it"));
    }
    out.push_back(std::move(factor));
  }
  return out;
}

Expected<void> check_subject(const TomlTable& top, const SweepKeys& keys) {
  if (top.has("program") && keys.tool) {
    return failure(top.problem("tool", "a program, or a tool", "there is a program already"));
  }
  if (!top.has("program") && !keys.tool) {
    return failure(top.missing("program", "program = \"panel.exc\", or tool = 1"));
  }
  if (top.has("pictures") && !keys.tool) {
    return failure(top.problem("pictures", "tool beside it", "a program asks for its pictures"));
  }
  return {};
}

/// The levels of a grid's factors; how many points they make is checked.
Expected<std::vector<std::size_t>> grid_levels(const TomlTable& top, const Sweep& sweep) {
  if (top.has("points")) {
    return failure(top.problem("points", "none of a grid", "levels and values decide"));
  }
  std::vector<std::size_t> levels;
  std::size_t n = 1;
  for (const Factor& factor : sweep.factors) {
    levels.push_back(factor.n_values());
    if (levels.back() == 0) {
      return failure(top.missing("levels of factor " + factor.key, "levels = 5, or values"));
    }
    n *= levels.back();
    if (n > kMaxPoints) break;
  }
  if (n <= kMaxPoints) return levels;
  return failure(top.problem(
      "design", fmt::format("at most {}", internal::grouped(kMaxPoints)), "too many points"));
}

Expected<void> draw_design(const TomlTable& top, const SweepKeys& keys, Sweep& sweep) {
  const std::size_t n_factors = sweep.factors.size();
  if (sweep.design == Design::Grid) {
    PANELCAL_TRY(const auto levels, grid_levels(top, sweep));
    sweep.shares = grid_shares(levels);
  } else if (!keys.n_points) {
    return failure(top.missing("points", "points = 100"));
  } else if (const auto n = static_cast<std::size_t>(*keys.n_points);
             sweep.design == Design::Sobol) {
    sweep.shares = sobol_shares(n, n_factors, sweep.seed);
  } else {
    sweep.shares = latin_hypercube_shares(n, n_factors, sweep.seed);
  }
  sweep.n_designed = static_cast<std::size_t>(sweep.shares.rows());
  if (sweep.n_points() <= kMaxPoints) return {};
  return failure(top.problem("repeats",
                             fmt::format("at most {} points", internal::grouped(kMaxPoints)),
                             "too many points"));
}

void set_number(toml::table& table, const SimKey& where, bool is_whole, double value) {
  const auto put = [&](auto number) {
    if (!where.i_component) {
      table.insert_or_assign(where.field->key, number);
    } else if (toml::array* const pair = table[where.field->key].as_array()) {
      pair->replace(pair->cbegin() + static_cast<std::ptrdiff_t>(*where.i_component), number);
    }
  };
  if (is_whole) {
    put(static_cast<std::int64_t>(value));
  } else {
    put(value);
  }
}

/// The table of a dotted name, made where it is missing.
toml::table* table_at(toml::table& document, std::string_view name) {
  toml::table* table = &document;
  while (table != nullptr && !name.empty()) {
    const std::size_t end = std::min(name.find('.'), name.size());
    const std::string_view key = name.substr(0, end);
    if (!table->contains(key)) table->insert(key, toml::table());
    table = (*table)[key].as_table();
    name.remove_prefix(std::min(end + 1, name.size()));
  }
  return table;
}

/// With six digits, so that a manifest states the very value.
double six_digits(double value) {
  double out = value;
  const std::string text = fmt::format("{:.6g}", value);
  std::from_chars(text.data(), text.data() + text.size(), out);
  return out;
}

std::string values_text(const Sweep& sweep, const Point& point) {
  std::string out;
  for (std::size_t i = 0; i < sweep.factors.size(); ++i) {
    out += fmt::format("{}{} = {}", i == 0 ? "" : ", ", sweep.factors[i].key, point.values[i]);
  }
  return out;
}

}  // namespace

std::size_t Factor::n_values() const {
  if (!values.empty()) return values.size();
  if (n_levels > 0) return static_cast<std::size_t>(n_levels);
  return 0;
}

double Factor::at(double share) const {
  const std::size_t n = n_values();
  const auto level = static_cast<double>(
      std::min(static_cast<std::size_t>(share * static_cast<double>(n)), n == 0 ? 0 : n - 1));
  if (!values.empty()) return values[static_cast<std::size_t>(level)];
  const double low = *from, high = *to;
  // Of whole numbers each one has an equal part.
  if (is_whole && n == 0 && !is_log) {
    return std::min(high, std::floor(low + share * (high - low + 1)));
  }
  const double along = n == 0 ? share : level / static_cast<double>(n - 1);
  if (along == 0) return low;
  if (along == 1) return high;
  const double value = is_log ? low * std::pow(high / low, along) : low + along * (high - low);
  return is_whole ? std::round(value) : std::clamp(six_digits(value), low, high);
}

Expected<Sweep> parse_sweep(std::string_view text, const std::filesystem::path& file) {
  const TomlSource source{file.string(), text};
  const FileDescription description{"the sweep", {&kSweep, &kFactor}};
  PANELCAL_TRY(const toml::table document, internal::parse_toml(source));
  PANELCAL_TRY(const TomlTable top, TomlTable::of_file(document, description, source));
  SweepKeys keys;
  PANELCAL_CHECK(top.read(kSweep, keys));
  PANELCAL_CHECK(check_subject(top, keys));
  Sweep sweep;
  sweep.file = file;
  sweep.machine = keys.machine;
  sweep.program = keys.program;
  sweep.tool = keys.tool;
  sweep.n_pictures = keys.n_pictures;
  sweep.design = keys.design;
  sweep.n_repeats = keys.n_repeats;
  sweep.seed = keys.seed;
  PANELCAL_TRY(sweep.factors, read_factors(top));
  if (sweep.factors.empty()) return failure(top.missing("factor", "[[factor]] with a key"));
  PANELCAL_CHECK(draw_design(top, keys, sweep));
  return sweep;
}

Expected<Sweep> read_sweep(const std::filesystem::path& file) {
  PANELCAL_TRY(const std::string text, read_file(file, kMaxSweepBytes));
  return parse_sweep(text, file);
}

Point point_of(const Sweep& sweep, std::size_t i) {
  Point point;
  point.id = fmt::format("{:06}", i + 1);
  // [sim] seed has 63 bits; 53 random ones are enough.
  point.seed = static_cast<std::uint64_t>(Random(sweep.seed).fork(i).fork(0).uniform() * 0x1p53);
  const auto row = static_cast<Eigen::Index>(i / static_cast<std::size_t>(sweep.n_repeats));
  for (std::size_t k = 0; k < sweep.factors.size(); ++k) {
    point.values.push_back(sweep.factors[k].at(sweep.shares(row, static_cast<Eigen::Index>(k))));
  }
  return point;
}

Expected<MachineConfig> machine_of(const Sweep& sweep,
                                   const Point& point,
                                   const std::string& machine_text) {
  const TomlSource source{sweep.machine.string(), machine_text};
  PANELCAL_TRY(toml::table document, internal::parse_toml(source));
  const auto refuse = [&](std::string what, std::string expected) {
    return failure({Code::ConfigValue,
                    {sweep.file.string(), 0, 0},
                    fmt::format("point {} ({}): {}", point.id, values_text(sweep, point), what),
                    std::move(expected)});
  };
  if (toml::table* const sim = table_at(document, "sim")) {
    sim->insert_or_assign("seed", static_cast<std::int64_t>(point.seed));
  }
  for (std::size_t i = 0; i < sweep.factors.size(); ++i) {
    const Factor& factor = sweep.factors[i];
    const std::optional<SimKey> where = sim_key(factor.key);
    toml::table* const table = where ? table_at(document, where->table) : nullptr;
    if (table == nullptr || (where->i_component && !(*table)[where->field->key].is_array())) {
      return refuse(quoted(factor.key) + " is not in machine.toml", "the pair there, [x, y]");
    }
    set_number(*table, *where, factor.is_whole, point.values[i]);
  }
  std::ostringstream text;
  text << document;
  auto config = parse_machine_config(text.str(), sweep.machine);
  if (config) return config;
  return refuse(config.error().what, config.error().expected);
}

}  // namespace panelcal::synth
