// SPDX-License-Identifier: MIT
#include "app/fact_list.h"

#include <algorithm>
#include <iostream>
#include <sstream>

namespace penumbra {

std::optional<Facts> parse_facts(const std::string& text, const Domain& domain) {
    Facts facts;
    std::istringstream words(text);
    const std::vector<std::string> known = domain.fact_list();
    for (std::string word; std::getline(words, word, ',');) {
        const bool negated = word.starts_with('!');
        const std::string name = word.substr(negated ? 1 : 0);
        if (std::find(known.begin(), known.end(), name) == known.end()) {
            std::cerr << "--facts: there is no fact \"" << name << "\"" << did_you_mean(name, known) << "\n";
            return std::nullopt;
        }
        if (facts.contains(name) && facts[name] == negated) {
            std::cerr << "--facts: \"" << name << "\" is said to be true and to be false\n";
            return std::nullopt;
        }
        facts[name] = !negated;
    }
    return facts;
}

std::vector<std::string> facts_not_taken(const Plan& plan, const Facts& given) {
    std::vector<std::string> warnings;
    for (const auto& [fact, holds] : given)
        if (plan.facts.at(fact) != holds)
            warnings.push_back("\"" + fact +
                               "\" is taken for true all the same, since frames are jittered (--no-jitter)");
    return warnings;
}

}  // namespace penumbra
