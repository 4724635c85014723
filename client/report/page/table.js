// A row a frame; a click on a head sorts, one on a row calls `pick` with the frame's index.
class Table {
  // columns: [{name, of(frame, index), text: of a number}]; marks: classes of the rows
  constructor(table, frames, columns, marks, pick) {
    const head = add(add(table, "thead"), "tr");
    this.body = add(table, "tbody");
    for (const column of columns) {
      const th = add(head, "th", column.name, column.text ? "number" : "");
      th.addEventListener("click", () => this.sort(column, th));
      th.title = "Sort";
    }
    this.rows = frames.map((frame, k) => {
      const row = add(this.body, "tr", "", marks[k]);
      for (const column of columns) {
        const value = column.of(frame, k);
        const cell = add(row, "td", column.text ? (value === null ? "" : column.text(value)) : value, column.text ? "number" : "");
        cell.title = cell.textContent;
      }
      row.addEventListener("click", () => pick(k));
      return { row, frame, k };
    });
  }

  // Ascending; the same head again turns it round. What has no value comes last.
  sort(column, th) {
    const order = th.ariaSort === "ascending" ? -1 : 1;
    for (const other of th.parentElement.children) other.ariaSort = null;
    th.ariaSort = order > 0 ? "ascending" : "descending";
    const sorted = [...this.rows].sort((a, b) => {
      const x = column.of(a.frame, a.k), y = column.of(b.frame, b.k);
      if (x === null || y === null) return (x === null) - (y === null);
      return order * (x < y ? -1 : x > y ? 1 : 0);
    });
    this.body.append(...sorted.map((entry) => entry.row));
  }

  show(k) {
    if (this.current) this.current.classList.remove("current");
    this.current = this.rows[k].row;
    this.current.classList.add("current");
    const box = this.body.parentElement.parentElement;
    const top = this.current.offsetTop, end = top + this.current.offsetHeight;
    if (top < box.scrollTop + 40) box.scrollTop = top - 40;
    if (end > box.scrollTop + box.clientHeight) box.scrollTop = end - box.clientHeight;
  }
}
