// SPDX-License-Identifier: MIT
// Documents: what they link to and name is there, and they can be read from the middle.
#include <fnmatch.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/project_files.h"

namespace penumbra::test {
namespace {

std::vector<fs::path> documents() {
    std::vector<fs::path> files{root / "README.md"};
    for (const auto& entry : fs::recursive_directory_iterator(root / "docs"))
        if (entry.path().extension() == ".md") files.push_back(entry.path());
    return files;
}

// Whoever opens a document in the middle of all learns there what its figure is: the first time that it is
// named, or before.
TEST(Documents, ADocumentSaysWhatNEffIs) {
    size_t users = 0;
    for (const fs::path& file : documents()) {
        const std::string text = std::regex_replace(read(file), std::regex("\\s+"), " ");
        const size_t first = text.find("N_eff");
        if (first == std::string::npos) continue;
        ++users;
        const std::string known = text.substr(0, first + 300);
        EXPECT_TRUE(std::regex_search(known, std::regex("[Ee]ffective (rays|samples)"))) << file;
    }
    EXPECT_GT(users, 10u);
}

// A table with more columns than a page is wide is read by nobody.
TEST(Documents, ATableOfADocumentHasAtMostEightColumns) {
    const std::vector<fs::path> files = documents();
    size_t tables = 0;
    for (const fs::path& file : files) {
        std::istringstream lines(read(file));
        bool code = false;
        for (std::string line; std::getline(lines, line);) {
            if (line.starts_with("```")) code = !code;
            if (code || !line.starts_with("|--")) continue;
            ++tables;
            EXPECT_LE(std::ranges::count(line, '|'), 9) << file << ": " << line;
        }
    }
    EXPECT_GT(tables, 100u);
}

// Of a heading's text, as GitHub makes it.
std::string anchor(const std::string& heading) {
    const std::string text = std::regex_replace(heading, std::regex("\\[([^\\]]*)\\]\\([^)]*\\)"), "$1");
    std::string out;
    for (const char c : text) {
        if (c == ' ') out += '-';
        if (std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_')
            out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    return out;
}

std::set<std::string> anchors_of(const fs::path& file) {
    std::set<std::string> found;
    std::istringstream lines(read(file));
    bool code = false;
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("```")) code = !code;
        if (code || !line.starts_with("#")) continue;
        const size_t text = line.find_first_not_of('#');
        if (text != std::string::npos && line[text] == ' ') found.insert(anchor(line.substr(text + 1)));
    }
    return found;
}

TEST(Documents, ALinkLeadsSomewhere) {
    std::map<fs::path, std::set<std::string>> anchors;
    const std::regex link("\\]\\(([^)\\s]+)\\)");
    size_t links = 0;
    for (const fs::path& file : documents()) {
        const std::string text = read(file);
        for (std::sregex_iterator m(text.begin(), text.end(), link), end; m != end; ++m) {
            const std::string to = (*m)[1];
            if (to.find("://") != std::string::npos) continue;
            ++links;
            const std::string path = to.substr(0, to.find('#'));
            const fs::path target = path.empty() ? file : (file.parent_path() / path).lexically_normal();
            ASSERT_TRUE(fs::exists(target)) << file << ": " << to;
            if (path.size() == to.size()) continue;
            const auto [known, fresh] = anchors.try_emplace(target);
            if (fresh) known->second = anchors_of(target);
            EXPECT_TRUE(known->second.contains(to.substr(to.find('#') + 1))) << file << ": " << to;
        }
    }
    EXPECT_GT(links, 500u);
}

// "Suite.Name" of every test in the sources, and the suites whose tests have further names when they run.
struct KnownTests {
    std::set<std::string> names, suites_of_many;
};
KnownTests known_tests() {
    const std::regex test("TEST(_F|_P)?\\(\\s*(\\w+),\\s*(\\w+)\\)");
    KnownTests known;
    for (const auto& file : fs::recursive_directory_iterator(root / "tests")) {
        if (file.path().extension() != ".cpp") continue;
        const std::string text = read(file.path());
        for (std::sregex_iterator m(text.begin(), text.end(), test), end; m != end; ++m) {
            known.names.insert((*m)[2].str() + "." + (*m)[3].str());
            if ((*m)[1] == "_P") known.suites_of_many.insert((*m)[2]);
        }
    }
    return known;
}

// `pattern` as --gtest_filter has it, of which an instance's name before the suite and after the test may be
// anything; `*` for a test of many instances may stand before the name of one.
bool is_there(const KnownTests& known, std::string pattern) {
    const size_t dot = pattern.find('.');
    if (dot == std::string::npos) return pattern.find_first_not_of("*/") != std::string::npos;
    if (const size_t instance = pattern.rfind('/', dot); instance != std::string::npos)
        pattern.erase(0, instance + 1);
    if (const size_t value = pattern.find('/'); value != std::string::npos) pattern.erase(value);
    const std::string suite = pattern.substr(0, pattern.find('.'));
    const auto fits = [](const std::string& glob) {
        return [&glob](const std::string& name) { return fnmatch(glob.c_str(), name.c_str(), 0) == 0; };
    };
    return std::ranges::any_of(known.names, fits(pattern)) ||
           (pattern[suite.size() + 1] == '*' && std::ranges::any_of(known.suites_of_many, fits(suite)));
}

TEST(Documents, ATestThatIsNamedIsThere) {
    const KnownTests known = known_tests();
    const std::regex filter("gtest_filter='([^']*)'"),
        name("`([A-Z]\\w*[a-z]\\w*\\.[A-Z]\\w*[a-z]\\w*)(\\*|\\.\\.\\.)?`"),
        bare("`([A-Z]\\w*[a-z]\\w*)(\\.\\.\\.)?`");  // in hard_cases.md, where the suites go without saying
    size_t named = 0;
    for (const fs::path& file : documents()) {
        const std::string text = read(file);
        std::vector<std::string> patterns;
        for (std::sregex_iterator m(text.begin(), text.end(), filter), end; m != end; ++m) {
            std::istringstream parts(std::regex_replace((*m)[1].str(), std::regex("-"), ":"));
            for (std::string part; std::getline(parts, part, ':');)
                if (!part.empty()) patterns.push_back(part);
        }
        for (std::sregex_iterator m(text.begin(), text.end(), name), end; m != end; ++m)
            patterns.push_back((*m)[1].str() + ((*m)[2].matched ? "*" : ""));
        if (file.filename() == "hard_cases.md")
            for (std::sregex_iterator m(text.begin(), text.end(), bare), end; m != end; ++m)
                patterns.push_back("*." + (*m)[1].str() + ((*m)[2].matched ? "*" : ""));
        for (const std::string& pattern : patterns) {
            ++named;
            EXPECT_TRUE(is_there(known, pattern)) << file << ": " << pattern;
        }
    }
    EXPECT_GT(named, 150u);
}

// Whoever looks for a phase finds all of it: `check*` is every file whose name begins so.
TEST(Documents, EveryFileOfTheGraphIsAPartOfAPhase) {
    const std::string page = read(root / "docs/architecture.md");
    std::vector<std::string> named;
    const std::regex word("`([a-z_]+\\*?)`");
    for (std::sregex_iterator m(page.begin(), page.end(), word), end; m != end; ++m) named.push_back((*m)[1]);
    size_t files = 0;
    for (const auto& entry : fs::directory_iterator(root / "graph")) {
        if (entry.path().extension() != ".cpp") continue;
        ++files;
        const std::string stem = entry.path().stem();
        EXPECT_TRUE(std::ranges::any_of(named, [&](const std::string& name) {
            return fnmatch(name.c_str(), stem.c_str(), 0) == 0;
        })) << stem;
    }
    EXPECT_GT(files, 40u);
}

// Relative to the root, to the file that names it, or to where its language looks for includes. A name in
// capitals stands for any.
TEST(Documents, AFileThatACommentNamesIsThere) {
    const std::regex comment("//.*"), file_name(R"([\w./-]+/[\w./-]+\.(h|cpp|glsl|comp|json|md|sh|py)\b)"),
        placeholder("[A-Z]{2,}");
    const std::set<std::string> examples{"pipelines/x.json"};
    size_t named = 0;
    for (const char* folder : {"app", "capi", "graph", "host", "include", "nodes", "shaders"})
        for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
            const fs::path& file = entry.path();
            if (!std::set<fs::path>{".h", ".cpp", ".glsl", ".comp"}.contains(file.extension())) continue;
            const std::string text = read(file);
            for (std::sregex_iterator c(text.begin(), text.end(), comment), end; c != end; ++c) {
                const std::string words = c->str();
                for (std::sregex_iterator m(words.begin() + 2, words.end(), file_name); m != end; ++m) {
                    const std::string name = m->str();
                    if (std::regex_search(name, placeholder) || examples.contains(name)) continue;
                    ++named;
                    const auto is_in = [&](const fs::path& at) { return fs::exists(at / name); };
                    EXPECT_TRUE(is_in(root) || is_in(file.parent_path()) || is_in(root / "include") ||
                                is_in(root / "shaders"))
                        << file << ": " << name;
                }
            }
        }
    EXPECT_GT(named, 100u);
}

}  // namespace
}  // namespace penumbra::test
