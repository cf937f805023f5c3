// The last rows of the stream, and what of them a plot of so many pixels can show.

const CAPACITY = 1 << 17; // 131 s at 1 kHz

export class Ring {
  constructor(names, capacity = CAPACITY) {
    this.names = names;
    this.capacity = capacity;
    this.t = new Float64Array(capacity);
    this.columns = names.map(() => new Float32Array(capacity));
    this.written = 0;
  }

  get lastTime() {
    return this.written ? this.t[(this.written - 1) % this.capacity] : NaN;
  }

  append(t, columns) {
    for (let k = 0; k < t.length; k++) {
      const place = (this.written + k) % this.capacity;
      this.t[place] = t[k];
      for (let i = 0; i < columns.length; i++) this.columns[i][place] = columns[i][k];
    }
    this.written += t.length;
  }

  // Places of the rows from `from` to `to`, in seconds.
  range(from, to) {
    const oldest = Math.max(0, this.written - this.capacity);
    const find = (limit) => {
      let low = oldest, high = this.written;
      while (low < high) {
        const middle = (low + high) >>> 1;
        if (this.t[middle % this.capacity] < limit) low = middle + 1;
        else high = middle;
      }
      return low;
    };
    return [find(from), find(to + 1e-9)];
  }

  // The rows of this time, to stay.
  copy(from, to) {
    const [first, last] = this.range(from, to);
    const kept = new Ring(this.names, Math.max(1, last - first));
    for (let at = first; at < last; at++) kept.append([this.t[at % this.capacity]], this.columns.map((column) => [column[at % this.capacity]]));
    return kept;
  }

  // The values of one signal in this time, one after the other.
  * values(place, from, to) {
    const [first, last] = this.range(from, to);
    for (let at = first; at < last; at++) yield this.columns[place][at % this.capacity];
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
      const number = Math.floor(this.t[at % this.capacity] / stretch);
      let end = at + 1;
      while (end < last && this.t[end % this.capacity] < (number + 1) * stretch) end++;
      t.push(number * stretch - offset, (number + 0.5) * stretch - offset);
      for (let i = 0; i < columns.length; i++) this.#extremes(this.columns[i], at, end, columns[i]);
      at = end;
    }
    return { t, columns };
  }

  #all(first, last, offset) {
    const t = [], columns = this.columns.map(() => []);
    for (let at = first; at < last; at++) {
      const place = at % this.capacity;
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
      const value = column[at % this.capacity];
      if (value < low) { low = value; lowAt = at; }
      if (value > high) { high = value; highAt = at; }
    }
    if (low > high) out.push(null, null);
    else if (lowAt <= highAt) out.push(low, high);
    else out.push(high, low);
  }

  // The row next to this time, of the signal in this place.
  at(place, time) {
    const [next] = this.range(time, time);
    const before = Math.max(0, this.written - this.capacity, next - 1), after = Math.min(next, this.written - 1);
    if (after < 0) return NaN;
    const closer = time - this.t[before % this.capacity] < this.t[after % this.capacity] - time ? before : after;
    return this.columns[place][closer % this.capacity];
  }

  // Mean of the last seconds: a figure that can be read.
  mean(name, seconds) {
    const column = this.columns[this.names.indexOf(name)];
    if (!column || !this.written) return NaN;
    let sum = 0, count = 0;
    for (let at = this.written - 1; at >= Math.max(0, this.written - this.capacity); at--) {
      if (this.t[at % this.capacity] < this.lastTime - seconds) break;
      const value = column[at % this.capacity];
      if (!Number.isNaN(value)) { sum += value; count++; }
    }
    return count ? sum / count : NaN;
  }
}
