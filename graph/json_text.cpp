// SPDX-License-Identifier: MIT
// JSON with places. nlohmann-json's SAX parser judges the text and delivers values, but not where they stand;
// scan() walks over the same text and lists where each token begins. Both see the same tokens in the same
// order, so the handler takes one place from the list per event.
#include "penumbra/json_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

namespace penumbra {

namespace {

constexpr size_t max_depth = 256;  // bounds the recursion of everything that walks a Json

struct Token {
    size_t offset = 0;
    int line = 1, column = 1;  // columns count characters, not bytes
    char first = '\0';         // '\0' for the end of the text
};

bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}
bool is_punctuation(char c) {
    return c == '{' || c == '}' || c == '[' || c == ']' || c == ',' || c == ':';
}

// Every token of the text; of malformed text, something near it. Ends with a token at the end of the text.
// Stops after `most` and one more.
std::vector<Token> scan(std::string_view text, size_t most) {
    std::vector<Token> tokens;
    size_t i = 0;
    int line = 1, column = 1;
    const auto step = [&] {
        const auto byte = static_cast<unsigned char>(text[i++]);
        if (byte == '\n') {
            ++line;
            column = 1;
        } else if ((byte & 0xc0) != 0x80) {  // not a UTF-8 continuation byte
            ++column;
        }
    };
    while (i < text.size() && tokens.size() <= most) {
        const char c = text[i];
        if (is_space(c)) {
            step();
            continue;
        }
        tokens.push_back({i, line, column, c});
        step();
        if (c == '"') {
            while (i < text.size() && text[i] != '"') {
                if (text[i] == '\\' && i + 1 < text.size()) step();
                step();
            }
            if (i < text.size()) step();
        } else if (!is_punctuation(c)) {
            while (i < text.size() && !is_space(text[i]) && !is_punctuation(text[i]) && text[i] != '"')
                step();
        }
    }
    tokens.push_back({text.size(), line, column, '\0'});
    return tokens;
}

// "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error while parsing value -
// invalid literal; last read: 'x'; expected '}'" without what our place says better.
std::string syntax_message(std::string text) {
    if (const size_t start = text.find("syntax error"); start != std::string::npos)
        text.erase(0, start);
    else if (const size_t end = text.find("] "); end != std::string::npos)
        text.erase(0, end + 2);
    if (const size_t read = text.find("; last read: '"); read != std::string::npos) {
        const size_t expected = text.rfind("'; expected ");
        const bool more = expected != std::string::npos && expected > read;
        text.erase(read, more ? expected + 1 - read : std::string::npos);
    }
    return text;
}

class TreeBuilder final : public nlohmann::json_sax<nlohmann::json> {
  public:
    TreeBuilder(const std::vector<Token>& tokens, const std::string& file, Diagnostics& diagnostics)
        : tokens_(tokens), file_(file), diagnostics_(diagnostics) {}

    Json take() { return std::move(root_); }

    bool null() override { return put(Json::Kind::null) != nullptr; }
    bool boolean(bool value) override {
        put(Json::Kind::boolean)->boolean = value;
        return true;
    }
    bool number_integer(number_integer_t value) override {
        Json* json = put(Json::Kind::integer);
        json->integer = value;
        json->real = static_cast<double>(value);
        return true;
    }
    bool number_unsigned(number_unsigned_t value) override {
        if (value <= static_cast<number_unsigned_t>(std::numeric_limits<int64_t>::max()))
            return number_integer(static_cast<number_integer_t>(value));
        return number_float(static_cast<double>(value), "");
    }
    bool number_float(number_float_t value, const string_t&) override {
        put(Json::Kind::real)->real = value;
        return true;
    }
    bool string(string_t& value) override {
        put(Json::Kind::string)->string = std::move(value);
        return true;
    }
    bool binary(binary_t&) override { return false; }  // no text form
    bool start_object(std::size_t) override { return open(Json::Kind::object); }
    bool start_array(std::size_t) override { return open(Json::Kind::array); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }

    bool key(string_t& value) override {
        const Place place = next_place();
        if (!keys_.back().insert(value).second)
            diagnostics_.add(place, path(), fmt::format("duplicate key \"{}\"", value));
        stack_.back()->members.push_back({std::move(value), place, {}});
        return true;
    }

    bool parse_error(std::size_t position, const std::string&,
                     const nlohmann::detail::exception& error) override {
        const size_t last_read = position == 0 ? 0 : position - 1;
        const Token* at = &tokens_.front();
        for (const Token& token : tokens_)
            if (token.offset <= last_read) at = &token;
        diagnostics_.add({file_, at->line, at->column}, "", syntax_message(error.what()));
        return false;
    }

  private:
    Place next_place() {
        while (next_ + 1 < tokens_.size() && is_closing(tokens_[next_].first)) ++next_;
        const Token& token = tokens_[next_];
        if (next_ + 1 < tokens_.size()) ++next_;
        return {file_, token.line, token.column};
    }
    static bool is_closing(char c) { return c == '}' || c == ']' || c == ',' || c == ':'; }

    // Appends a value to the innermost open container. Pointers on the stack stay valid: only the innermost
    // grows.
    Json* put(Json::Kind kind) {
        Json* slot = &root_;
        if (!stack_.empty()) {
            Json* parent = stack_.back();
            if (parent->kind == Json::Kind::array)
                slot = &parent->items.emplace_back();
            else
                slot = &parent->members.back().value;
        }
        slot->kind = kind;
        slot->place = next_place();
        return slot;
    }

    bool open(Json::Kind kind) {
        Json* json = put(kind);
        if (stack_.size() == max_depth) {
            diagnostics_.add(json->place, "", fmt::format("nested more than {} levels deep", max_depth));
            return false;
        }
        stack_.push_back(json);
        keys_.emplace_back();
        return true;
    }

    bool close() {
        stack_.pop_back();
        keys_.pop_back();
        return true;
    }

    std::string path() const {  // of the innermost open container
        std::string path;
        for (size_t i = 0; i + 1 < stack_.size(); ++i) {
            if (stack_[i]->kind == Json::Kind::array)
                path += fmt::format("[{}]", stack_[i]->items.size() - 1);
            else
                path += (path.empty() ? "" : ".") + stack_[i]->members.back().key;
        }
        return path;
    }

    const std::vector<Token>& tokens_;
    const std::string& file_;
    Diagnostics& diagnostics_;
    size_t next_ = 0;
    Json root_;
    std::vector<Json*> stack_;
    std::vector<std::set<std::string, std::less<>>> keys_;  // of each open container
};

JsonMember* find_member(Json& object, std::string_view key) {
    for (JsonMember& member : object.members)
        if (member.key == key) return &member;
    return nullptr;
}

void move_to(Json& json, const Place& place) {
    json.place = place;
    for (Json& item : json.items) move_to(item, place);
    for (JsonMember& member : json.members) {
        member.key_place = place;
        move_to(member.value, place);
    }
}

}  // namespace

const Json* Json::find(std::string_view key) const {
    for (const JsonMember& member : members)
        if (member.key == key) return &member.value;
    return nullptr;
}

const char* kind_name(Json::Kind kind) {
    switch (kind) {
        case Json::Kind::null:
            return "null";
        case Json::Kind::boolean:
            return "a boolean";
        case Json::Kind::integer:
            return "an integer";
        case Json::Kind::real:
            return "a real number";
        case Json::Kind::string:
            return "a string";
        case Json::Kind::array:
            return "an array";
        case Json::Kind::object:
            return "an object";
    }
    return "";
}

std::optional<Json> parse_json(std::string_view text, const std::string& file, Diagnostics& diagnostics,
                               size_t most_tokens) {
    const size_t errors = diagnostics.size();
    // The parser would skip a byte order mark (RFC 8259 lets it), shifting every place on the first line.
    if (text.starts_with("\xef\xbb\xbf")) {
        diagnostics.add({file, 1, 1}, "", "the file begins with a byte order mark; save it as plain UTF-8");
        return std::nullopt;
    }
    const std::vector<Token> tokens = scan(text, most_tokens);
    if (tokens.size() == 1) {
        diagnostics.add({file, 1, 1}, "", "the file is empty");
        return std::nullopt;
    }
    if (tokens.size() > most_tokens) {
        const Token& last = tokens[most_tokens];
        diagnostics.add(
            {file, last.line, last.column}, "",
            fmt::format("the text has more than {} values, keys and punctuation marks", most_tokens));
        return std::nullopt;
    }
    // The parser takes a NUL byte for the end of the text and would accept whatever follows.
    if (const size_t nul = text.find('\0'); nul != std::string_view::npos) {
        const auto after =
            std::upper_bound(tokens.begin(), tokens.end(), nul,
                             [](size_t offset, const Token& token) { return offset < token.offset; });
        const Token& at = after == tokens.begin() ? tokens.front() : *std::prev(after);
        diagnostics.add({file, at.line, at.column}, "", "the file holds a NUL byte");
        return std::nullopt;
    }
    TreeBuilder builder(tokens, file, diagnostics);
    const bool parsed = nlohmann::json::sax_parse(text.begin(), text.end(), &builder);
    if (!parsed || diagnostics.size() != errors) return std::nullopt;
    return builder.take();
}

std::optional<Json> read_json(const std::filesystem::path& path, Diagnostics& diagnostics,
                              size_t most_tokens) {
    const std::string file = path.generic_string();
    std::error_code error;
    if (!std::filesystem::exists(path, error)) {
        diagnostics.add({file}, "", "no such file");
        return std::nullopt;
    }
    std::ifstream stream;
    if (!std::filesystem::is_directory(path, error)) stream.open(path, std::ios::binary);
    if (!stream.is_open()) {
        diagnostics.add({file}, "", "cannot be read");
        return std::nullopt;
    }
    // No token takes as much on average, spaces and texts included; and a device never ends.
    const size_t most_bytes = 64 * most_tokens;
    std::string text;
    std::array<char, 65536> piece;
    while (text.size() <= most_bytes && stream) {
        stream.read(piece.data(), piece.size());
        text.append(piece.data(), static_cast<size_t>(stream.gcount()));
    }
    if (text.size() > most_bytes) {
        diagnostics.add({file}, "", fmt::format("has more than {} bytes", most_bytes));
        return std::nullopt;
    }
    if (stream.bad()) {
        diagnostics.add({file}, "", "cannot be read");
        return std::nullopt;
    }
    return parse_json(text, file, diagnostics, most_tokens);
}

void merge_patch(Json& target, const Json& patch) {
    if (patch.kind != Json::Kind::object) {
        target = patch;
        return;
    }
    if (target.kind != Json::Kind::object) {
        target = Json{};
        target.kind = Json::Kind::object;
        target.place = patch.place;
    }
    std::map<std::string, size_t, std::less<>>
        index;  // of the target's members; what is removed leaves the list last
    for (size_t i = 0; i < target.members.size(); ++i) index.try_emplace(target.members[i].key, i);
    std::vector<bool> removed(target.members.size());
    for (const JsonMember& member : patch.members) {
        const auto [at, added] = index.try_emplace(member.key, target.members.size());
        if (added) {
            if (member.value.kind == Json::Kind::null) {
                index.erase(at);
                continue;
            }
            target.members.push_back({member.key, member.key_place, {}});
            removed.push_back(false);
        }
        JsonMember& existing = target.members[at->second];
        removed[at->second] = member.value.kind == Json::Kind::null;
        if (removed[at->second]) continue;
        if (member.value.kind != Json::Kind::object) existing.key_place = member.key_place;
        merge_patch(existing.value, member.value);
    }
    size_t kept = 0;
    for (size_t i = 0; i < target.members.size(); ++i)
        if (!removed[i]) {
            if (kept != i) target.members[kept] = std::move(target.members[i]);
            ++kept;
        }
    target.members.erase(target.members.begin() + static_cast<ptrdiff_t>(kept), target.members.end());
}

void set_path(Json& target, std::string_view path, std::string_view value_text, const Place& place) {
    Json* at = &target;
    for (size_t begin = 0; begin <= path.size();) {
        const size_t end = std::min(path.find('.', begin), path.size());
        const std::string_view key = path.substr(begin, end - begin);
        if (at->kind != Json::Kind::object) {
            *at = Json{};
            at->kind = Json::Kind::object;
            at->place = place;
        }
        JsonMember* member = find_member(*at, key);
        if (!member) {
            member = &at->members.emplace_back(JsonMember{std::string(key), place, {}});
            member->value.place = place;
        }
        at = &member->value;
        if (end == path.size()) member->key_place = place;
        begin = end + 1;
    }
    Diagnostics unused;  // text that is no JSON is a string
    if (std::optional<Json> value = parse_json(value_text, place.file, unused)) {
        *at = std::move(*value);
    } else {
        *at = Json{};
        at->kind = Json::Kind::string;
        at->string = value_text;
    }
    move_to(*at, place);
}

}  // namespace penumbra
