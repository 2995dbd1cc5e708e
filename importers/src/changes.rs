//! What is done to all columns of a table alike: room is made, rows are sorted, left out or repeated.

/// A change of columns. Columns without rows stay as they are.
pub(crate) trait Change {
    /// Changes a column that has rows.
    fn apply<T: Copy>(&mut self, column: &mut Vec<T>);
}

/// Makes room for so many rows in all.
pub(crate) struct Reserve(pub(crate) usize);

impl Change for Reserve {
    fn apply<T: Copy>(&mut self, column: &mut Vec<T>) {
        column.reserve_exact(self.0.saturating_sub(column.len()));
    }
}

/// Keeps the rows for which this is true.
pub(crate) struct Keep<'a>(pub(crate) &'a [bool]);

impl Change for Keep<'_> {
    fn apply<T: Copy>(&mut self, column: &mut Vec<T>) {
        let mut rows = self.0.iter();
        column.retain(|_| rows.next().copied().unwrap_or(false));
    }
}

/// Replaces the rows by those of these indices, which may repeat.
pub(crate) struct Gather<'a>(pub(crate) &'a [usize]);

impl Change for Gather<'_> {
    fn apply<T: Copy>(&mut self, column: &mut Vec<T>) {
        *column = self.0.iter().map(|&row| column[row]).collect();
    }
}

/// Permutes the rows in place: columns of ten million rows are not held twice.
pub(crate) struct Permute {
    /// For each row, which one comes there.
    order: Vec<u32>,
    is_done: Vec<bool>,
}

impl Permute {
    /// Sorts by `keys`, one for each row. Rows with the same key keep their order.
    pub(crate) fn sorting(keys: &[u64]) -> Self {
        let mut order: Vec<u32> = (0..keys.len() as u32).collect();
        order.sort_by_key(|&row| keys[row as usize]);
        Self { order, is_done: vec![false; keys.len()] }
    }
}

impl Change for Permute {
    fn apply<T: Copy>(&mut self, column: &mut Vec<T>) {
        self.is_done.fill(false);
        for start in 0..self.order.len() {
            if self.is_done[start] {
                continue;
            }
            let (first, mut row) = (column[start], start);
            loop {
                self.is_done[row] = true;
                let next = self.order[row] as usize;
                if next == start {
                    break;
                }
                column[row] = column[next];
                row = next;
            }
            column[row] = first;
        }
    }
}
