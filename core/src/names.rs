//! Names that select.

use std::collections::{HashMap, HashSet};

/// Makes names unique by appending numbers to repeated ones: `Wheel`, `Wheel 2`. The first keeps its name.
pub fn told_apart(names: Vec<String>) -> Vec<String> {
    let mut taken: HashSet<String> = names.iter().cloned().collect();
    let mut counts: HashMap<String, usize> = HashMap::new();
    let mut apart = |name: String| {
        let count = counts.entry(name.clone()).or_insert(0);
        *count += 1;
        if *count == 1 {
            return name;
        }
        while !taken.insert(format!("{name} {count}")) {
            *count += 1;
        }
        format!("{name} {count}")
    };
    names.into_iter().map(&mut apart).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_names_get_the_next_free_number() {
        let names = ["a", "b", "a", "a 2", "a", ""].map(str::to_owned).to_vec();
        assert_eq!(told_apart(names), ["a", "b", "a 3", "a 2", "a 4", ""]);
    }
}
