//! Spelling suggestions: one rule for keys, groups, regions, patterns and all
//! else.

/// The known name nearest to `word`, if it is near enough to be meant: a third of the letters differ at most,
/// or one of them begins with the other. Letters count alike whether small or capital.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = word.to_lowercase();
    let distance = |name: &str| {
        let name = name.to_lowercase();
        let shorter = wanted.chars().count().min(name.chars().count());
        let begins = shorter >= 3 && (name.starts_with(&wanted) || wanted.starts_with(&name));
        let letters = strsim::osa_distance(&wanted, &name);
        (letters <= (shorter / 3).max(1) && shorter > 1 || begins || wanted == name).then_some(letters)
    };
    let near = known.into_iter().filter_map(|name| Some((distance(name)?, name)));
    near.min_by_key(|(letters, _)| *letters).map(|(_, name)| name)
}

/// `; did you mean …?`, to be put behind a message; empty where nothing is near.
pub fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, known).map_or(String::new(), |name| format!("; did you mean `{name}`?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_of_the_pen_are_found_and_other_words_are_not() {
        let keys = ["title", "mesh", "material", "support", "load", "time", "young", "poisson", "density"];
        for (written, meant) in [
            ("yung", "young"),
            ("laod", "load"),
            ("Mesh", "mesh"),
            ("materials", "material"),
            ("suport", "support"),
            ("dens", "density"),
            ("poison", "poisson"),
            ("tiem", "time"),
        ] {
            assert_eq!(nearest(written, keys), Some(meant), "{written}");
        }
        for other in ["contact", "E", "nu", "rho", "", "x", "step", "gravity"] {
            assert_eq!(nearest(other, keys), None, "{other}");
        }
        assert_eq!(did_you_mean("x_mni", ["x_max", "x_min"]), "; did you mean `x_min`?");
        assert_eq!(did_you_mean("top", []), "");
    }
}
