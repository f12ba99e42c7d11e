//! Choices of a mutation, read from bytes of a random generator or a fuzzer.

/// Bytes that determine a mutation. Once they are used up, every further choice is the first option.
pub struct Choices<'a> {
    bytes: &'a [u8],
}

impl<'a> Choices<'a> {
    /// Creates choices from `bytes`.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    /// Whether all bytes are used up.
    pub fn are_over(&self) -> bool {
        self.bytes.is_empty()
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        let (first, rest) = self.bytes.split_first().unwrap_or((&0, &[]));
        self.bytes = rest;
        *first
    }

    /// A number below `count`, or 0 if `count` is 0. Uses as few bytes as `count` needs.
    pub fn below(&mut self, count: usize) -> usize {
        let bytes = match count {
            0..=1 => return 0,
            2..=0x100 => 1,
            0x101..=0x1_0000 => 2,
            _ => 4,
        };
        (0..bytes).fold(0, |number, _| number << 8 | usize::from(self.byte())) % count
    }

    /// True once in `count` times.
    pub fn one_in(&mut self, count: usize) -> bool {
        self.below(count) == count - 1
    }

    /// An element of `all`, which must not be empty.
    pub fn of<'b, T>(&mut self, all: &'b [T]) -> &'b T {
        &all[self.below(all.len())]
    }

    /// A range within a sequence of `length`, usually short.
    pub fn range(&mut self, length: usize) -> std::ops::Range<usize> {
        let start = self.below(length);
        let longest = if self.one_in(8) { length } else { 16 };
        start..(start + 1 + self.below(longest)).min(length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_come_from_the_bytes_and_end_with_them() {
        let mut choices = Choices::new(&[7, 1, 2, 255]);
        assert_eq!((choices.below(1), choices.below(5), choices.below(1000)), (0, 2, 258));
        assert!(!choices.are_over() && choices.byte() == 255 && choices.are_over());
        assert_eq!((choices.below(9), choices.range(4)), (0, 0..1));
        assert_eq!(choices.range(0), 0..0);
    }
}
