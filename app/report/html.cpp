// SPDX-License-Identifier: MIT
#include "app/report/html.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <set>
#include <stdexcept>

namespace penumbra::report {

std::string escape(std::string_view text) {
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
            case '\'':
                out += "&#39;";
                break;
            default:
                out += c;
        }
    }
    return out;
}

std::string fill(std::string_view page, const std::map<std::string, std::string>& values) {
    std::string out;
    std::set<std::string> used;
    for (size_t at = 0;;) {
        const size_t open = page.find("{{", at);
        out += page.substr(at, open == std::string_view::npos ? open : open - at);
        if (open == std::string_view::npos) break;
        const size_t close = page.find("}}", open);
        if (close == std::string_view::npos) throw std::logic_error("template: {{ without }}");
        const std::string name(page.substr(open + 2, close - open - 2));
        const auto value = values.find(name);
        if (value == values.end()) throw std::logic_error("template: no value for " + name);
        used.insert(name);
        out += value->second;
        at = close + 2;
    }
    for (const auto& [name, value] : values)
        if (!used.contains(name)) throw std::logic_error("template: no place for " + name);
    return out;
}

Table::Table(std::string caption, std::vector<Column> columns)
    : caption_(std::move(caption)), columns_(std::move(columns)) {}

void Table::row(const std::vector<std::string>& cells, const std::string& style) {
    if (cells.size() != columns_.size()) throw std::logic_error("table: a row of another length");
    rows_ += style.empty() ? "<tr>" : fmt::format("<tr class=\"{}\">", style);
    for (size_t i = 0; i < cells.size(); ++i) {
        // The row's name is its header; what it is a row of follows.
        const char* tag = i == 0 ? "th scope=\"row\"" : "td";
        rows_ += fmt::format("<{}{}>{}</{}>", tag, columns_[i].number ? " class=\"n\"" : "", cells[i],
                             i == 0 ? "th" : "td");
    }
    rows_ += "</tr>\n";
}

std::string Table::html() const {
    std::string out = "<div class=\"table\"><table>";
    if (!caption_.empty()) out += fmt::format("<caption>{}</caption>", escape(caption_));
    out += "<thead><tr>";
    for (const Column& column : columns_)
        out += fmt::format("<th scope=\"col\"{}>{}</th>", column.number ? " class=\"n\"" : "",
                           escape(column.head));
    return out + "</tr></thead>\n<tbody>\n" + rows_ + "</tbody></table></div>\n";
}

std::string base64(std::string_view bytes) {
    constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (size_t i = 0; i < bytes.size(); i += 3) {
        const size_t have = std::min<size_t>(3, bytes.size() - i);
        uint32_t word = 0;
        for (size_t k = 0; k < 3; ++k)
            word = word << 8 | (k < have ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (size_t k = 0; k < 4; ++k) out += k <= have ? digits[word >> (18 - 6 * k) & 63] : '=';
    }
    return out;
}

std::string number(double value) {
    if (!std::isfinite(value)) return "not finite";
    const double size = std::abs(value);
    if (size >= 100) return fmt::format("{:.0f}", value);
    if (size >= 10) return fmt::format("{:.1f}", value);
    if (size >= 1) return fmt::format("{:.2f}", value);
    if (size >= 0.1 || size == 0) return fmt::format("{:.3f}", value);
    if (size >= 0.001) return fmt::format("{:.4f}", value);
    return fmt::format("{:.1e}", value);
}

}  // namespace penumbra::report
