// What the pages of the workbench do in the browser; Python calls the functions of `tribofmu` by their names.

// A picture that leaves the page while it is being sized has nothing to size any more; plotly calls that an error.
addEventListener('unhandledrejection', (event) => {
  if (String(event.reason?.message ?? event.reason).includes('Resize must be passed a displayed plot div')) event.preventDefault();
});

// A page that is built anew is short for a moment. It keeps its length, or who reads further down would be thrown to the top.
{
  let at = 0, timer = 0;
  addEventListener('scroll', () => { at = scrollY }, {passive: true});
  const watch = () => {
    const content = document.getElementById('content');
    if (!content) return requestAnimationFrame(watch);
    // On a phone the names of the pages are one line, moved sideways: that of this page is in sight.
    const here = document.querySelector('nav .here');
    if (here) here.parentElement.scrollLeft = here.offsetLeft - (here.parentElement.clientWidth - here.offsetWidth) / 2;
    const free = () => {
      if (content.hasAttribute('aria-busy')) timer = setTimeout(free, 500);
      else content.style.minHeight = '';
    };
    new MutationObserver(() => {
      if (at) content.style.minHeight = `${at + innerHeight}px`;
      clearTimeout(timer);
      timer = setTimeout(free, 500);
    }).observe(content, {childList: true});
  };
  watch();
}

window.tribofmu = {
  // A new tab stays white until its page is there: what was pressed says at once that it comes, until somebody is back.
  opening(event) {
    const link = event.currentTarget, said = link.textContent;
    if (link.hasAttribute('aria-busy')) return;
    link.setAttribute('aria-busy', 'true');
    link.textContent = 'Opening in a new tab ...';
    const back = () => {
      if (document.hidden) return;
      clearTimeout(timer);
      document.removeEventListener('visibilitychange', back);
      link.removeAttribute('aria-busy');
      link.textContent = said;
    };
    const timer = setTimeout(back, 8000);
    document.addEventListener('visibilitychange', back);
  },

  // Adds the files of folders that are dropped on the area; the browser hands out a folder only piece by piece.
  takeFolders(area) {
    if (!area) return;  // the page went away meanwhile
    const up = area.$refs.qRef, host = area.$el;
    const take = (list) => { if (list.length) up.addFiles(list) };
    const read = (entry) => new Promise((done) => {
      if (entry.isFile) return entry.file((f) => done([f]), () => done([]));
      const reader = entry.createReader(); const all = [];
      const more = () => reader.readEntries((part) => {
        if (!part.length) return done(Promise.all(all).then((x) => x.flat()));
        for (const e of part) if (e.isFile && !e.name.startsWith('.')) all.push(read(e));
        more();
      }, () => done([]));
      more();
    });
    host.addEventListener('drop', (e) => {
      const entries = [...(e.dataTransfer.items || [])].map((i) => i.webkitGetAsEntry && i.webkitGetAsEntry()).filter((x) => x);
      if (!entries.some((x) => x.isDirectory)) return;
      e.preventDefault(); e.stopPropagation();
      Promise.all(entries.map(read)).then((x) => take(x.flat()));
    }, true);
  },

  // Lets one choose a folder, and adds its files to the area.
  pickFolder(id) {
    const field = document.createElement('input');
    field.type = 'file'; field.webkitdirectory = true; field.multiple = true;
    field.oncancel = () => getElement(id).$el.dispatchEvent(new Event('cancel'));
    field.onchange = () => {
      const found = [...field.files].filter((f) => !f.name.startsWith('.'));
      if (found.length) getElement(id).$refs.qRef.addFiles(found);
    };
    field.click();
  },

  // Changes the layout of pictures.
  relayout(ids, change) {
    for (const id of ids) {
      const plot = getElement(id);
      if (plot && plot.Plotly) plot.Plotly.relayout(plot.$el, change);
    }
  },

  // What is picked in one picture is picked in all: pictures have the same curves of points, so that numbers of points agree.
  // With `whole` all points of the tests are picked. The server hears which tests these are, and not the points.
  brush(event, id, ids, whole, emit) {
    // Marking points makes pictures report a change of their own: that is no new choice.
    if (this.brushing) return;
    this.brushing = true;
    const done = [];
    const own = getElement(id).$el;
    const clouds = (el) => el._fullData.map((t, k) => k).filter((k) => el._fullData[k].customdata);
    const mine = clouds(own), picked = mine.map(() => []), tests = new Set();
    const points = (event && event.points) || [];
    for (const p of points) {
      const k = mine.indexOf(p.curveNumber);
      if (k < 0) continue;
      picked[k].push(p.pointNumber); tests.add(own._fullData[p.curveNumber].customdata[p.pointNumber]);
    }
    if (whole && tests.size) mine.forEach((k, n) => {
      const of = own._fullData[k].customdata, all = [];
      for (let i = 0; i < of.length; i++) if (tests.has(of[i])) all.push(i);
      picked[n] = all;
    });
    for (const other of ids) {
      const plot = getElement(other);
      if (!plot || !plot.Plotly) continue;
      const rest = plot.$el === own && !whole ? {} : {selections: []};
      done.push(plot.Plotly.update(plot.$el, {selectedpoints: tests.size ? picked : [null]}, rest, clouds(plot.$el)));
    }
    Promise.allSettled(done).then(() => setTimeout(() => { this.brushing = false }, 200));
    emit([...tests].map(Number));
  },
};
