//! What stands in a source file, word by word: comments and texts do not count.

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// One token of a file, groups taken apart, with its line.
#[derive(Clone, Debug)]
pub struct Word {
    pub text: String,
    pub line: usize,
}

/// The tokens of a source, in order.
pub fn words(path: &str, text: &str) -> Vec<Word> {
    let tokens: TokenStream = text.parse().unwrap_or_else(|e| panic!("{path}: {e}"));
    let mut words = vec![];
    flatten(tokens, &mut words);
    words
}

fn flatten(tokens: TokenStream, words: &mut Vec<Word>) {
    for token in tokens {
        let line = token.span().start().line;
        let mut word = |text: &str| words.push(Word { text: text.to_string(), line });
        match token {
            TokenTree::Group(group) => {
                let [open, close] = match group.delimiter() {
                    Delimiter::Parenthesis => ["(", ")"],
                    Delimiter::Brace => ["{", "}"],
                    Delimiter::Bracket => ["[", "]"],
                    Delimiter::None => ["", ""],
                };
                word(open);
                flatten(group.stream(), words);
                words.push(Word { text: close.to_string(), line });
            }
            token => word(&token.to_string()),
        }
    }
}

/// Lines where the words stand in this order, one after the other.
pub fn lines_of(words: &[Word], sought: &[&str]) -> Vec<usize> {
    let is_there = |window: &&[Word]| window.iter().map(|w| w.text.as_str()).eq(sought.iter().copied());
    words.windows(sought.len()).filter(is_there).map(|window| window[0].line).collect()
}
