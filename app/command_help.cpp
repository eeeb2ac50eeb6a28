// SPDX-License-Identifier: MIT
#include "app/command_help.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "app/shipped_files.h"
#include "app/view_source.h"
#include "penumbra/diagnostic.h"

namespace penumbra {
namespace {

struct Example {
    const char *line, *what;
};

const std::map<std::string, std::vector<Example>>& examples() {
    static const std::map<std::string, std::vector<Example>> table{
        {"render",
         {{"penumbra render model.glb --ground", "a picture of a model, into out/model"},
          {"penumbra render shadows --shot colonnade --frames 0..15 --out out/a",
           "a shipped pipeline on a shipped shot"},
          {"penumbra render mine.json --nodes nodes --shot my.shot.json --capture depth",
           "a pipeline with node types of your own, and its depth"}}},
        {"view",
         {{"penumbra view model.glb --ground", "a window; the tab `keys` says how to fly"},
          {"penumbra view shadows --shot colonnade --beside error", "the mask's error while nothing moves"},
          {"penumbra view mine.json --nodes nodes --shot engine",
           "nodes of your own: saved shaders and JSON are taken over at once"},
          {"penumbra view --shot engine --headless view.png", "what the window would show, without one"}}},
        {"shot",
         {{"penumbra shot model.glb --ground --out my.shot.json", "a shot to begin with"},
          {"penumbra shot room.glb chair.glb --out both.shot.json", "of two models"}}},
        {"reference",
         {{"penumbra reference --like out/a --out out/truth",
           "the truth of just the points that a rendered folder shows"},
          {"penumbra reference --shot engine --frames 15 --rays 4096 --out out/truth",
           "of pixel centres, finer"}}},
        {"compare",
         {{"penumbra compare out/a out/truth", "how far a mask is from the truth"},
          {"penumbra compare out/a out/truth --also out/a2 --json", "two seeds, as JSON"}}},
        {"report",
         {{"penumbra report --quick --out out/report", "a page for a first look, in minutes"},
          {"penumbra report --front --shots lamp --out out/front", "speed against error alone"}}},
        {"plan",
         {{"penumbra plan hybrid_shadows --size 1920x1080", "passes, barriers, memory; no device is needed"},
          {"penumbra plan raw --size 640x360 --format dot | dot -Tsvg", "the dataflow as a drawing"}}},
        {"check", {{"penumbra check pipelines/*.json", "every error of these files"}}},
        {"nodes",
         {{"penumbra nodes", "all node types"},
          {"penumbra nodes trace", "what one takes, gives and can be told"}}},
        {"gates", {{"penumbra gates shadows --parts still", "straight penumbrae with a known answer"}}},
        {"bench",
         {{"penumbra bench hybrid_shadows shadows --shots lamp", "what two pipelines cost, pass by pass"}}},
        {"explain",
         {{"penumbra explain --shot colonnade --out sun.svg", "what one pixel sees of the sun"},
          {"penumbra explain --shot colonnade --gather --out gather.svg",
           "what the rays of the pixels around say of it"},
          {"penumbra explain --shot colonnade --beams --out beams.svg",
           "why whole tiles are lit or dark without a ray, and others are not"},
          {"penumbra explain --shot colonnade --frame 15 --budget --out budget.png",
           "which pixels got rays, and how many"},
          {"penumbra explain --costs out/*/report.json --out costs.svg", "where the time went"}}},
        {"statics", {{"penumbra statics shadows", "what the compilers make of its shaders"}}},
        {"devices", {{"penumbra devices", "the names that --device takes a part of"}}},
        {"completion",
         {{"penumbra completion bash >~/.local/share/bash-completion/completions/penumbra",
           "for every new shell"},
          {"source <(penumbra completion zsh)", "for this one"}}}};
    return table;
}

// "--out", "-h": as they are typed.
std::vector<std::string> option_names(const CLI::App& command) {
    std::vector<std::string> names;
    for (const CLI::Option* option : command.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    return names;
}

// What can stand after an option or as a command's argument; nothing where that is anything, or a file.
std::vector<std::string> values_of(const CLI::Option& option) {
    const std::string name = option.get_name(), type = option.get_type_name();
    if (name == "--shot" || name == "--shots") return shipped_names(shipped_root(), shipped_shots);
    if (name == "pipeline" || name == "pipelines" || name == "files" || name == "--pipelines")
        return shipped_names(shipped_root(), shipped_pipelines);
    std::vector<std::string> values;  // of CLI::IsMember: TEXT:{a,b}
    if (const size_t at = type.find('{'); at != type.npos) {
        std::istringstream list(type.substr(at + 1, type.find('}') - at - 1));
        for (std::string value; std::getline(list, value, ',');) values.push_back(value);
    }
    return values;
}

std::string bash_script(const CLI::App& app) {
    std::vector<std::string> commands;
    std::string cases, values;
    const auto add = [&](const std::string& pattern, const std::vector<std::string>& list) {
        if (!list.empty())
            values += fmt::format("        {}) words='{}' ;;\n", pattern, fmt::join(list, " "));
    };
    for (const CLI::App* command : app.get_subcommands({})) {
        commands.push_back(command->get_name());
        cases += fmt::format("        {}) words='{}' ;;\n", command->get_name(),
                             fmt::join(option_names(*command), " "));
        for (const CLI::Option* option : command->get_options())
            if (!option->get_positional())
                add(command->get_name() + ":" + option->get_name(), values_of(*option));
        // After an option that takes a value stands that; an option without one is no different from a file.
        std::vector<std::string> valued;
        for (const CLI::Option* option : command->get_options())
            if (!option->get_positional() && option->get_items_expected_max() > 0)
                for (const std::string& name : option->get_lnames()) valued.push_back("--" + name);
        for (const CLI::Option* option : command->get_options())
            if (const auto list = values_of(*option); option->get_positional() && !list.empty()) {
                for (std::string& name : valued) name = command->get_name() + ":" + name;
                if (!valued.empty()) values += fmt::format("        {}) ;;\n", fmt::join(valued, "|"));
                add(command->get_name() + ":*", list);
            }
    }
    return fmt::format(R"(# Completion of penumbra's commands, options and their values; file names elsewhere.
_penumbra() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} words=
    if [[ $COMP_CWORD == 1 ]]; then
        COMPREPLY=($(compgen -W '{}' -- "$word"))
        return
    fi
    if [[ $word == -* ]]; then
        case ${{COMP_WORDS[1]}} in
{}        esac
    else
        case ${{COMP_WORDS[1]}}:${{COMP_WORDS[COMP_CWORD - 1]}} in
{}        esac
    fi
    COMPREPLY=($(compgen -W "$words" -- "$word"))
}}
complete -o default -F _penumbra penumbra
)",
                       fmt::join(commands, " "), cases, values);
}

std::string quoted(std::string text) {
    for (size_t at = 0; (at = text.find('\'', at)) != text.npos; at += 2) text.insert(at, "\\");
    return "'" + text + "'";
}

std::string fish_script(const CLI::App& app) {
    std::string text = "# Completion of penumbra's commands, options and their values.\n";
    for (const CLI::App* command : app.get_subcommands({})) {
        const std::string of =
            "complete -c penumbra -n '__fish_seen_subcommand_from " + command->get_name() + "'";
        text += fmt::format("complete -c penumbra -n __fish_use_subcommand -a {} -d {}\n",
                            command->get_name(), quoted(command->get_description()));
        for (const CLI::Option* option : command->get_options()) {
            const auto values = values_of(*option);
            const std::string list = values.empty() ? "" : fmt::format(" -a '{}'", fmt::join(values, " "));
            if (option->get_positional() && !list.empty()) text += of + list + "\n";
            for (const std::string& name : option->get_lnames())
                text += fmt::format("{} -l {}{}{} -d {}\n", of, name,
                                    option->get_items_expected_max() > 0 ? " -r" : "", list,
                                    quoted(option->get_description()));
        }
    }
    return text;
}

// An option that takes one value at a time, or a list with commas, is not shown as one that takes several.
class Formatter : public CLI::Formatter {
    std::string make_option_opts(const CLI::Option* option) const override {
        std::string text = CLI::Formatter::make_option_opts(option);
        const size_t several = text.find(" ...");
        if (several == text.npos || option->get_allow_extra_args()) return text;
        return text.replace(several, 4, option->get_delimiter() ? ",..." : " (may be repeated)");
    }
};

}  // namespace

std::string wrong_words(const CLI::App& app, const CLI::ParseError& error,
                        const std::vector<std::string>& words) {
    const auto chosen = app.get_subcommands();
    if (chosen.empty()) {
        std::vector<std::string> names = option_names(app);
        for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
        const std::string guess =
            is_model_file(words[0])
                ? fmt::format("; a picture of it is made by `penumbra render {}`", words[0])
                : did_you_mean(words[0], names);
        return fmt::format("{}: no such command{}\nRun `penumbra --help` for a list of them.\n", words[0],
                           guess);
    }
    std::string text = error.what();
    if (const auto* extras = dynamic_cast<const CLI::ExtrasError*>(&error); extras && !chosen.empty())
        for (const std::string& word : app.remaining(true))
            text += did_you_mean(word.substr(0, word.find('=')), option_names(*chosen[0]));
    return fmt::format("{}\nRun `penumbra {} --help` for more information.\n", text, chosen[0]->get_name());
}

void add_examples(CLI::App& app) {
    size_t given = 0;
    for (CLI::App* command : app.get_subcommands({})) {
        const auto found = examples().find(command->get_name());
        if (found == examples().end()) throw std::logic_error("no example of " + command->get_name());
        ++given;
        command->formatter(std::make_shared<Formatter>());
        std::string text = "\nExamples:\n";
        for (const Example& example : found->second)
            text += fmt::format("  {}\n      {}\n", example.line, example.what);
        text += "\nExit code: 0 good, 1 the work failed, 2 the command or a file is wrong.";
        command->footer(text);
    }
    if (given != examples().size()) throw std::logic_error("examples of a command that does not exist");
}

std::string completion_script(const CLI::App& app, const std::string& shell) {
    if (shell == "fish") return fish_script(app);
    // bashcompinit stands on compinit, which a shell without a .zshrc has not called.
    constexpr const char* zsh =
        "(( $+functions[compdef] )) || { autoload -Uz compinit && compinit -i }\n"
        "autoload -U +X bashcompinit && bashcompinit\n";
    return (shell == "zsh" ? zsh : "") + bash_script(app);
}

}  // namespace penumbra
