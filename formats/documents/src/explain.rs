//! serde's messages in the words of a document's author, with what was probably meant.

/// serde's message in an author's words; `example` shows a word with a table.
pub(super) fn explain(message: &str, example: &str) -> String {
    for (kind, word) in [("unknown field `", "key"), ("unknown variant `", "value")] {
        let Some((name, known)) = message.strip_prefix(kind).and_then(|rest| rest.split_once("`, ")) else {
            continue;
        };
        let known: Vec<&str> = known.split('`').skip(1).step_by(2).collect();
        let meant = nearest(name, &known);
        return match (known.is_empty(), meant.is_empty()) {
            (true, _) => format!("unknown {word} `{name}`; none is known here"),
            (_, false) => format!("unknown {word} `{name}`; did you mean `{}`?", meant.join("` or `")),
            _ => format!("unknown {word} `{name}`; known here: {}", known.join(", ")),
        };
    }
    if let Some(name) = message.strip_prefix("missing field ") {
        return format!("the key {name} is missing");
    }
    if message.contains("expected newtype variant") || message.contains("expected struct variant") {
        return format!("this one needs a table with its settings, as {example}");
    }
    message.replace('\n', "; ")
}

/// The known words that were probably meant: the closest, or those that hold the name or a part of it.
fn nearest<'a>(name: &str, known: &[&'a str]) -> Vec<&'a str> {
    let plain = |word: &str| word.to_lowercase().replace('-', "_");
    let name = plain(name);
    let distance = |word: &&&str| strsim::damerau_levenshtein(&name, &plain(word));
    let closest = known.iter().min_by_key(distance);
    if let Some(closest) = closest.filter(|word| 3 * distance(word) <= name.len().max(word.len())) {
        return vec![closest];
    }
    let related =
        |word: &&str| name.len() > 3 && (plain(word).contains(&name) || name.contains(&plain(word)));
    known.iter().copied().filter(related).collect()
}
