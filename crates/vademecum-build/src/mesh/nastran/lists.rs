//! Lists of numbers on Nastran cards.

/// Ranges, first and last, of a list of numbers with `THRU` and `EXCEPT`; a single number is a range of its
/// own. None if the list is not of this form.
pub fn ranges(fields: &[String]) -> Option<Vec<[u64; 2]>> {
    let mut found: Vec<[u64; 2]> = Vec::new();
    let mut words = fields.iter().map(|field| field.trim()).filter(|field| !field.is_empty());
    // Place and end of a range with exceptions.
    let mut except: Option<(usize, u64)> = None;
    while let Some(word) = words.next() {
        if word.eq_ignore_ascii_case("THRU") {
            let end: u64 = words.next()?.parse().ok()?;
            let last = found.last_mut().filter(|range| range[0] == range[1] && range[0] <= end)?;
            last[1] = end;
        } else if word.eq_ignore_ascii_case("EXCEPT") {
            except = Some((found.len().checked_sub(1)?, found.last()?[1]));
        } else {
            let id: u64 = word.parse().ok()?;
            match except.filter(|(_, end)| id <= *end) {
                Some((start, _)) => leave_out(&mut found, start, id),
                None => {
                    except = None;
                    found.push([id, id]);
                }
            }
        }
    }
    Some(found)
}

/// Takes a number out of ascending ranges that begin at a place of the list.
fn leave_out(found: &mut Vec<[u64; 2]>, start: usize, id: u64) {
    let Some(place) = found.iter().skip(start).position(|range| range[0] <= id && id <= range[1]) else {
        return;
    };
    let [first, last] = found.remove(start + place);
    if id < last {
        found.insert(start + place, [id + 1, last]);
    }
    if first < id {
        found.insert(start + place, [first, id - 1]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_have_ranges_and_exceptions() {
        let of = |text: &str| ranges(&text.split(' ').map(str::to_string).collect::<Vec<_>>());
        assert_eq!(of("1 5 3"), Some(vec![[1, 1], [5, 5], [3, 3]]));
        assert_eq!(of("1 THRU 72"), Some(vec![[1, 72]]));
        assert_eq!(of("4  1 thru 9 EXCEPT 3 9 20"), Some(vec![[4, 4], [1, 2], [4, 8], [20, 20]]));
        assert_eq!(of("1 THRU 2 EXCEPT 1 2 7"), Some(vec![[7, 7]]));
        assert_eq!(of("1 THRU 5 EXCEPT 4 2 2"), Some(vec![[1, 1], [3, 3], [5, 5]]));
        for wrong in ["THRU 3", "1 THRU", "5 THRU 3", "1 THRU 3 THRU 5", "a", "1 BY 2", "EXCEPT 1", "-1"] {
            assert_eq!(of(wrong), None, "{wrong}");
        }
    }
}
