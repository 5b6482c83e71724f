/* SPDX-License-Identifier: MIT */
#include "obj.h"

namespace cli
{

namespace
{

constexpr std::string_view blanks = " \t\r\f\v";

} // namespace

/* One line, with those that continue it, into text_. */
void WordLines::fetch()
{
    text_.clear();
    line_ += height_ - 1;
    height_ = 0;
    for (bool more = true; more && !left_.empty(); height_++) {
        const size_t end = std::min(left_.find('\n'), left_.size());
        std::string_view part = left_.substr(0, end);
        left_.remove_prefix(std::min(end + 1, left_.size()));
        while (!part.empty() && part.back() == '\r')
            part.remove_suffix(1);
        more = !part.empty() && part.back() == '\\';
        if (more)
            part.remove_suffix(1);
        text_ += part;
        if (more)
            text_ += ' ';
    }
    line_++;
}

bool WordLines::next()
{
    words_.clear();
    while (words_.empty() && !left_.empty()) {
        fetch();
        const std::string_view text = text_;
        for (size_t at = text.find_first_not_of(blanks);
             at != std::string_view::npos && text[at] != '#';) {
            const size_t end = std::min(text.find_first_of(blanks, at), text.size());
            words_.push_back(text.substr(at, end - at));
            at = text.find_first_not_of(blanks, end);
        }
    }
    return !words_.empty();
}

std::string WordLines::rest(size_t i) const
{
    if (i >= words_.size())
        return "";
    const std::string_view text = text_;
    const size_t start = static_cast<size_t>(words_[i].data() - text.data());
    return std::string(text.substr(start, text.find_last_not_of(blanks) + 1 - start));
}

std::optional<double> WordLines::number(size_t i) const
{
    return i < words_.size() ? parse_number(std::string(words_[i])) : std::nullopt;
}

} // namespace cli
