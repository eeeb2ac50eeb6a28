// SPDX-License-Identifier: MIT
// The little HTML that the report needs: escaping, templates whose every place must be filled, tables.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra::report {

// For text and for attribute values in double quotes.
std::string escape(std::string_view text);

// Replaces every {{name}}; throws std::logic_error where the template names what is not given, or is given
// what it does not name: both are mistakes of ours. Values are inserted as they are and not searched again.
std::string fill(std::string_view page, const std::map<std::string, std::string>& values);

// Rows of cells; numbers are set right-aligned. Cells hold markup: text goes through escape() first.
class Table {
  public:
    struct Column {
        std::string head;  // text
        bool number = true;
    };

    Table(std::string caption, std::vector<Column> columns);
    // As many cells as columns, or std::logic_error. `style` is the row's class.
    void row(const std::vector<std::string>& cells, const std::string& style = {});
    std::string html() const;

  private:
    std::string caption_;
    std::vector<Column> columns_;
    std::string rows_;
};

std::string base64(std::string_view bytes);  // RFC 4648, padded

// Two to three significant digits, without an exponent down to 0.001; a dash for nothing.
std::string number(double value);
template <class Optional>
std::string number_or_dash(const Optional& value) {
    return value ? number(*value) : "–";
}

}  // namespace penumbra::report
