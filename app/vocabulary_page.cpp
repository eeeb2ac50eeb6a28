// SPDX-License-Identifier: MIT
#include "app/vocabulary_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "app/node_text.h"
#include "graph/vocabulary.h"
#include "penumbra/format.h"

namespace penumbra {
namespace {

std::string quoted(const std::vector<std::string>& words) {
    return words.empty() ? "" : "`" + joined(words, "` `") + "`";
}

std::string numbers(const Key& key) {
    const std::string limits = fmt::format("{} .. {}", key.least, key.greatest);
    if (key.holds == Holds::whole)
        return key.multiple == 1 ? limits : fmt::format("{}, a multiple of {}", limits, key.multiple);
    const std::string more = key.max_items > key.min_items ? fmt::format(" or {}", key.max_items) : "";
    return fmt::format("{}{} numbers, {}", key.min_items, more, limits);
}

std::string plain(const Key& key, const Domain& domain) {
    static const std::map<Holds, const char*> always = {
        {Holds::text, "text"},
        {Holds::file, "file name"},
        {Holds::shader, "NAME.comp"},
        {Holds::line, "one line"},
        {Holds::id, "id"},
        {Holds::ids, "list of ids"},
        {Holds::flag, "`true` `false`"},
        {Holds::yes, "`true`"},
        {Holds::version, "`1`"},
        {Holds::range, "[least, greatest]"},
        {Holds::ranges, "[least, greatest], or a list with one for each channel"},
        {Holds::node_type, "node type"},
        {Holds::format, "format"},
        {Holds::storable, "format, none of depth"},
        {Holds::formats, "format, or a list"},
        {Holds::storables, "format, or a list, none of depth"},
        {Holds::structure, "struct's name"},
        {Holds::condition, "condition"},
        {Holds::value, "of its type"},
        {Holds::values, "{ parameter: value }"},
        {Holds::facts, "{ fact: `true` `false` }"},
        {Holds::wires, "{ port: name }"}};
    if (key.holds == Holds::whole || key.holds == Holds::wholes) return numbers(key);
    if (key.holds == Holds::kind) return quoted(kind_words(domain));
    if (key.holds == Holds::needs) return "list of " + quoted(need_words(domain));
    if (key.holds == Holds::truths) return "list of " + quoted(domain.fact_list());
    if (key.holds == Holds::objects) return fmt::format("{{ id: [{0}](#{0}) }}", key.object->name);
    return always.at(key.holds);
}

std::string value_of(const Key& key, const Domain& domain) {
    std::vector<std::string> any;
    if (!key.words.empty()) any.push_back(quoted(split_words(key.words)));
    if (key.holds != Holds::word && key.holds != Holds::object) any.push_back(plain(key, domain));
    if (key.object && key.holds != Holds::objects)
        any.push_back(fmt::format("[{0}](#{0})", key.object->name));
    return joined(any, ", or ");
}

std::string kinds_of(Kinds kinds, const std::vector<std::string>& words) {
    std::vector<std::string> list;
    for (size_t i = 0; i < words.size(); ++i)
        if (kinds & bit(std::min(i, words.size() - 1))) list.push_back(words[i]);
    return list.size() == words.size() ? "all" : joined(list, ", ");
}

// Where a key applies, for objects whose keys depend on one of them.
std::string where(const Object& object, const Key& key, const Domain& domain) {
    if (&object != &vocabulary::port)
        return kinds_of(key.in, &object == &vocabulary::param ? param_type_words() : kind_words(domain));
    std::vector<std::string> parts;
    if (key.in) parts.push_back("in: " + kinds_of(key.in, kind_words(domain)));
    if (key.out) parts.push_back("out: " + kinds_of(key.out, kind_words(domain)));
    if (!key.updating) parts.emplace_back("not where it updates");
    return joined(parts, "; ");
}

}  // namespace

std::string vocabulary_page(const Domain& domain) {
    std::string page =
        "# Keys of node declarations and pipelines\n\n"
        "Made by `penumbra nodes --format vocabulary` from graph/vocabulary.cpp, which the readers and the "
        "JSON "
        "Schemas follow.\n**Bold** keys are required where they apply.\n\n"
        "- id: `[a-z][a-z0-9_]*`, at most 64 characters\n- format: " +
        quoted(format_names()) +
        "\n- condition: facts, and constant parameters (in a pipeline NODE.PARAM) that may be compared with "
        "a value "
        "by `=` `!=` `<` `<=` `>` `>=`;\n  `!` negates one, `&` joins, `|` stands between alternatives\n\n"
        "Facts, true where the host does not deny them:\n";
    for (const Fact& fact : domain.facts) page += fmt::format("- `{}`: {}\n", fact.name, fact.doc);
    for (const Object* object : vocabulary::objects()) {
        const bool selects = !object->selector.empty();
        page += fmt::format("\n## {}\n\n{}\n", object->name, object->doc);
        if (!object->exactly_one.empty())
            page += fmt::format("Exactly one of {}.\n", quoted(split_words(object->exactly_one)));
        page += fmt::format("\n| key | value | {}what |\n|---|---|{}---|\n", selects ? "where | " : "",
                            selects ? "---|" : "");
        for (const Key& key : object->keys) {
            const std::string beside =
                key.beside.empty() ? "" : fmt::format("; beside `{}` alone", key.beside);
            page += fmt::format("| {0}`{1}`{0} | {2} | {3}{4}{5} |\n", key.required ? "**" : "", key.name,
                                value_of(key, domain), selects ? where(*object, key, domain) + " | " : "",
                                key.doc, beside);
        }
    }
    return page;
}

}  // namespace penumbra
