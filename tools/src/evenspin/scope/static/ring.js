// The last rows of the stream, and what of them a plot of so many pixels can show.

const CAPACITY = 1 << 17; // 131 s at 1 kHz

export class Ring {
  constructor(names) {
    this.names = names;
    this.t = new Float64Array(CAPACITY);
    this.columns = names.map(() => new Float32Array(CAPACITY));
    this.written = 0;
  }

  get lastTime() {
    return this.written ? this.t[(this.written - 1) % CAPACITY] : NaN;
  }

  append(t, columns) {
    for (let k = 0; k < t.length; k++) {
      const place = (this.written + k) % CAPACITY;
      this.t[place] = t[k];
      for (let i = 0; i < columns.length; i++) this.columns[i][place] = columns[i][k];
    }
    this.written += t.length;
  }

  // Places of the rows from `from` to `to`, in seconds.
  range(from, to) {
    const oldest = Math.max(0, this.written - CAPACITY);
    const find = (limit) => {
      let low = oldest, high = this.written;
      while (low < high) {
        const middle = (low + high) >>> 1;
        if (this.t[middle % CAPACITY] < limit) low = middle + 1;
        else high = middle;
      }
      return low;
    };
    return [find(from), find(to + 1e-9)];
  }

  // {t, columns}: all rows, or minimum and maximum of each stretch of time. The stretches lie fast in time, so that the
  // picture moves without shimmering. Lost rows are null.
  window(from, to, pixels, offset = 0) {
    const [first, last] = this.range(from, to);
    if (last - first <= 2 * pixels) return this.#all(first, last, offset);
    const stretch = (to - from) / pixels;
    const t = [], columns = this.columns.map(() => []);
    let at = first;
    while (at < last) {
      const number = Math.floor(this.t[at % CAPACITY] / stretch);
      let end = at + 1;
      while (end < last && this.t[end % CAPACITY] < (number + 1) * stretch) end++;
      t.push(number * stretch - offset, (number + 0.5) * stretch - offset);
      for (let i = 0; i < columns.length; i++) this.#extremes(this.columns[i], at, end, columns[i]);
      at = end;
    }
    return { t, columns };
  }

  #all(first, last, offset) {
    const t = [], columns = this.columns.map(() => []);
    for (let at = first; at < last; at++) {
      const place = at % CAPACITY;
      t.push(this.t[place] - offset);
      for (let i = 0; i < columns.length; i++) {
        const value = this.columns[i][place];
        columns[i].push(Number.isNaN(value) ? null : value);
      }
    }
    return { t, columns };
  }

  // In the order in which they came: a ramp stays a ramp.
  #extremes(column, first, last, out) {
    let low = Infinity, high = -Infinity, lowAt = 0, highAt = 0;
    for (let at = first; at < last; at++) {
      const value = column[at % CAPACITY];
      if (value < low) { low = value; lowAt = at; }
      if (value > high) { high = value; highAt = at; }
    }
    if (low > high) out.push(null, null);
    else if (lowAt <= highAt) out.push(low, high);
    else out.push(high, low);
  }

  // Mean of the last seconds: a figure that can be read.
  mean(name, seconds) {
    const column = this.columns[this.names.indexOf(name)];
    if (!column || !this.written) return NaN;
    let sum = 0, count = 0;
    for (let at = this.written - 1; at >= Math.max(0, this.written - CAPACITY); at--) {
      if (this.t[at % CAPACITY] < this.lastTime - seconds) break;
      const value = column[at % CAPACITY];
      if (!Number.isNaN(value)) { sum += value; count++; }
    }
    return count ? sum / count : NaN;
  }
}
