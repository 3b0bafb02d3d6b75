#include "tools/vtbench/report/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace vt::bench {
namespace {

constexpr const char* kInk = "#1f2933";
constexpr const char* kQuiet = "#627080";
constexpr const char* kGrid = "#e3e8ed";
constexpr const char* kOurs = "#1769aa";
constexpr const char* kPeer = "#b4bfca";
// Told apart by people who see colours differently, too (after Okabe and Ito).
constexpr std::array kSeriesColors = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"};

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return out;
}

enum class Anchor { kStart, kMiddle, kEnd };

// How wide a text will be drawn; an estimate is enough to keep labels apart.
double text_width(const std::string& text, double size) { return 0.56 * size * static_cast<double>(text.size()); }

class Drawing {
 public:
  Drawing(double width, double height) : width_(width), height_(height) {}

  void rect(double x, double y, double width, double height, const char* fill, double radius = 0.0) {
    body_ += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" rx=\"{:.0f}\" fill=\"{}\"/>\n", x, y, width,
                         height, radius, fill);
  }
  void line(double x1, double y1, double x2, double y2, const char* color, double width = 1.0, const char* dashes = nullptr) {
    const std::string dash = dashes == nullptr ? "" : fmt::format(" stroke-dasharray=\"{}\"", dashes);
    body_ += fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" stroke-width=\"{:.1f}\"{}/>\n", x1,
                         y1, x2, y2, color, width, dash);
  }
  void circle(double x, double y, double radius, const char* fill) {
    body_ += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" fill=\"{}\" stroke=\"#ffffff\" stroke-width=\"1.5\"/>\n", x, y,
                         radius, fill);
  }
  void text(double x, double y, const std::string& text, double size, const char* color, Anchor anchor = Anchor::kStart, bool bold = false,
            bool upright = true) {
    constexpr std::array kAnchors = {"start", "middle", "end"};
    const std::string turn = upright ? "" : fmt::format(" transform=\"rotate(-90 {:.1f} {:.1f})\"", x, y);
    body_ += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{:.0f}\" fill=\"{}\" text-anchor=\"{}\"{}{}>{}</text>\n", x, y, size,
                         color, kAnchors[static_cast<std::size_t>(anchor)], bold ? " font-weight=\"600\"" : "", turn, escaped(text));
  }

  [[nodiscard]] std::string finish() const {
    return fmt::format(
               "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
               "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
               "font-family=\"Helvetica, Arial, sans-serif\">\n"
               "<rect width=\"{0:.0f}\" height=\"{1:.0f}\" fill=\"#ffffff\"/>\n",
               width_, height_) +
           body_ + "</svg>\n";
  }

 private:
  double width_;
  double height_;
  std::string body_;
};

constexpr double kTitleSize = 18.0;
constexpr double kTextSize = 13.0;
constexpr double kSmallSize = 11.0;

void draw_notes(Drawing& drawing, const std::vector<std::string>& notes, double x, double y) {
  for (const std::string& note : notes) {
    drawing.text(x, y, note, kSmallSize, kQuiet);
    y += 15.0;
  }
}

std::string tick_text(double value) { return fmt::format("{:.6g}", value); }

struct Box {
  double left, top, right, bottom;
  [[nodiscard]] bool overlaps(const Box& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
};

// Where to put a label near its point so that it covers neither points nor labels: above, below, then further
// out.
struct LabelPlacer {
  std::vector<Box> taken;

  // The label's middle and base line. When every place is taken, the first one all the same.
  std::pair<double, double> place(double x, double y, double width) {
    const double beside = width / 2 + 9.0;
    const std::array<std::pair<double, double>, 10> offsets = {{{0.0, -9.0},
                                                                {0.0, 19.0},
                                                                {beside, 4.0},
                                                                {-beside, 4.0},
                                                                {beside, -12.0},
                                                                {-beside, -12.0},
                                                                {beside, 21.0},
                                                                {-beside, 21.0},
                                                                {0.0, -23.0},
                                                                {0.0, 33.0}}};
    for (const auto& [dx, dy] : offsets) {
      const Box box{x + dx - width / 2, y + dy - 10.0, x + dx + width / 2, y + dy + 3.0};
      if (std::none_of(taken.begin(), taken.end(), [&](const Box& other) { return box.overlaps(other); })) {
        taken.push_back(box);
        return {x + dx, y + dy};
      }
    }
    return {x, y + offsets.front().second};
  }
};

}  // namespace

std::vector<double> round_ticks(double low, double high, int count) {
  if (!(high > low)) high = low + 1.0;
  const double rough = (high - low) / std::max(count, 1);
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double mantissa = rough / power;
  const double step = power * (mantissa <= 1.0 ? 1.0 : mantissa <= 2.0 ? 2.0 : mantissa <= 5.0 ? 5.0 : 10.0);
  std::vector<double> ticks;
  const auto first = static_cast<std::int64_t>(std::floor(low / step));
  const auto last = static_cast<std::int64_t>(std::ceil(high / step));
  for (std::int64_t i = first; i <= last; ++i) ticks.push_back(static_cast<double>(i) * step);
  return ticks;
}

std::string svg_of(const BarChart& chart) {
  constexpr double kWidth = 860.0;
  constexpr double kLeft = 250.0;
  constexpr double kRight = 90.0;
  constexpr double kTop = 52.0;
  constexpr double kBar = 20.0;
  constexpr double kBarGap = 6.0;
  constexpr double kGroupTitle = 28.0;
  double plot_height = 0.0;
  double high = 0.0;
  for (const BarGroup& group : chart.groups) {
    plot_height += kGroupTitle + static_cast<double>(group.bars.size()) * (kBar + kBarGap);
    for (const Bar& bar : group.bars) high = std::max({high, bar.value, bar.high});
  }
  const double bottom = kTop + plot_height + 8.0;
  Drawing drawing(kWidth, bottom + 56.0 + 15.0 * static_cast<double>(chart.notes.size()));
  drawing.text(20.0, 30.0, chart.title, kTitleSize, kInk, Anchor::kStart, true);

  const std::vector<double> ticks = round_ticks(0.0, high, 6);
  const auto x_of = [&](double value) { return kLeft + (kWidth - kLeft - kRight) * value / ticks.back(); };
  for (const double tick : ticks) {
    drawing.line(x_of(tick), kTop, x_of(tick), bottom, kGrid);
    drawing.text(x_of(tick), bottom + 16.0, tick_text(tick), kSmallSize, kQuiet, Anchor::kMiddle);
  }
  drawing.text((x_of(0.0) + x_of(ticks.back())) / 2, bottom + 34.0, chart.axis, kTextSize, kInk, Anchor::kMiddle);

  double y = kTop;
  for (const BarGroup& group : chart.groups) {
    drawing.text(20.0, y + 19.0, group.title, kTextSize, kInk, Anchor::kStart, true);
    y += kGroupTitle;
    for (const Bar& bar : group.bars) {
      const double middle = y + kBar / 2;
      drawing.text(kLeft - 10.0, middle + 4.5, bar.label, kTextSize, kInk, Anchor::kEnd);
      drawing.rect(kLeft, y, x_of(bar.value) - kLeft, kBar, bar.is_ours ? kOurs : kPeer, 2.0);
      if (bar.high > bar.low) drawing.line(x_of(bar.low), middle, x_of(bar.high), middle, kInk);
      drawing.text(x_of(std::max(bar.value, bar.high)) + 8.0, middle + 4.5, fmt::format("{:.0f}", bar.value), kTextSize, kInk,
                   Anchor::kStart, bar.is_ours);
      y += kBar + kBarGap;
    }
  }
  draw_notes(drawing, chart.notes, 20.0, bottom + 56.0);
  return drawing.finish();
}

std::string svg_of(const ScatterChart& chart) {
  constexpr double kWidth = 860.0;
  constexpr double kHeight = 520.0;  // of the plot and its axes, without notes
  constexpr double kLeft = 76.0;
  constexpr double kRight = 30.0;
  constexpr double kTop = 84.0;
  constexpr double kBottom = 62.0;

  double x_low = 1e300;
  double x_high = -1e300;
  double y_low = 1e300;
  double y_high = -1e300;
  for (const Series& series : chart.series)
    for (const Point& point : series.points) {
      x_low = std::min(x_low, point.x);
      x_high = std::max(x_high, point.x);
      y_low = std::min(y_low, point.y);
      y_high = std::max(y_high, point.y);
    }
  if (chart.line) {
    y_low = std::min(y_low, chart.line->y);
    y_high = std::max(y_high, chart.line->y);
  }

  // A little air, so that labels stay inside.
  const double air = 0.08 * (y_high - y_low);
  const std::vector<double> y_ticks = round_ticks(y_low - air, y_high + air, 6);
  std::vector<double> x_ticks;
  double x_from = 0.0;
  double x_to = 0.0;
  if (chart.log_x) {
    // 1, 2 and 5 of every decade that the points reach, with a little air on both sides.
    x_from = std::log10(x_low * 0.8);
    x_to = std::log10(x_high * 1.25);
    for (int decade = static_cast<int>(std::floor(x_from)); decade <= static_cast<int>(std::ceil(x_to)); ++decade)
      for (const double step : {1.0, 2.0, 5.0}) {
        const double tick = step * std::pow(10.0, decade);
        if (std::log10(tick) >= x_from && std::log10(tick) <= x_to) x_ticks.push_back(tick);
      }
  } else {
    x_ticks = round_ticks(std::min(0.0, x_low), x_high, 8);
    x_from = x_ticks.front();
    x_to = x_ticks.back();
  }
  const auto x_of = [&](double x) {
    const double along = ((chart.log_x ? std::log10(x) : x) - x_from) / (x_to - x_from);
    return kLeft + (kWidth - kLeft - kRight) * along;
  };
  const auto y_of = [&](double y) {
    return kHeight - kBottom - (kHeight - kTop - kBottom) * (y - y_ticks.front()) / (y_ticks.back() - y_ticks.front());
  };

  Drawing drawing(kWidth, kHeight + 8.0 + 15.0 * static_cast<double>(chart.notes.size()));
  drawing.text(20.0, 30.0, chart.title, kTitleSize, kInk, Anchor::kStart, true);
  for (const double tick : x_ticks) {
    drawing.line(x_of(tick), kTop, x_of(tick), kHeight - kBottom, kGrid);
    drawing.text(x_of(tick), kHeight - kBottom + 18.0, tick_text(tick), kSmallSize, kQuiet, Anchor::kMiddle);
  }
  for (const double tick : y_ticks) {
    drawing.line(kLeft, y_of(tick), kWidth - kRight, y_of(tick), kGrid);
    drawing.text(kLeft - 8.0, y_of(tick) + 4.0, tick_text(tick), kSmallSize, kQuiet, Anchor::kEnd);
  }
  drawing.line(kLeft, kHeight - kBottom, kWidth - kRight, kHeight - kBottom, kQuiet);
  drawing.line(kLeft, kTop, kLeft, kHeight - kBottom, kQuiet);
  drawing.text((kLeft + kWidth - kRight) / 2, kHeight - kBottom + 42.0, chart.x_axis, kTextSize, kInk, Anchor::kMiddle);
  drawing.text(24.0, (kTop + kHeight - kBottom) / 2, chart.y_axis, kTextSize, kInk, Anchor::kMiddle, false, false);

  LabelPlacer placer;
  for (const Series& series : chart.series)
    for (const Point& point : series.points)
      placer.taken.push_back({x_of(point.x) - 5.0, y_of(point.y) - 5.0, x_of(point.x) + 5.0, y_of(point.y) + 5.0});
  if (chart.line) {
    const double y = y_of(chart.line->y);
    drawing.line(kLeft, y, kWidth - kRight, y, kQuiet, 1.5, "6 4");
    drawing.text(kLeft + 8.0, y - 7.0, chart.line->label, kSmallSize, kQuiet);
    placer.taken.push_back({kLeft, y - 18.0, kLeft + 8.0 + text_width(chart.line->label, kSmallSize), y});
  }

  double legend_x = 20.0;
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const Series& series = chart.series[i];
    const char* color = kSeriesColors[i % kSeriesColors.size()];
    drawing.circle(legend_x + 5.0, 54.0, 5.5, color);
    drawing.text(legend_x + 16.0, 58.5, series.name, kTextSize, kInk);
    legend_x += 44.0 + text_width(series.name, kTextSize);
    for (std::size_t p = 0; series.is_joined && p + 1 < series.points.size(); ++p)
      drawing.line(x_of(series.points[p].x), y_of(series.points[p].y), x_of(series.points[p + 1].x), y_of(series.points[p + 1].y), color,
                   1.5);
    for (const Point& point : series.points) drawing.circle(x_of(point.x), y_of(point.y), 5.5, color);
  }
  for (std::size_t i = 0; i < chart.series.size(); ++i)
    for (const Point& point : chart.series[i].points) {
      const auto [x, y] = placer.place(x_of(point.x), y_of(point.y), text_width(point.label, kSmallSize) + 3.0);
      drawing.text(x, y, point.label, kSmallSize, kSeriesColors[i % kSeriesColors.size()], Anchor::kMiddle);
    }
  draw_notes(drawing, chart.notes, 20.0, kHeight + 2.0);
  return drawing.finish();
}

}  // namespace vt::bench
