window.Plotly = {calls: [], newPlot(...call) { return new Promise((drawn) => this.calls.push([call, drawn])); }};
addEventListener('DOMContentLoaded', () => {
  const draw = () => {
    const waiting = window.Plotly.calls, library = document.createElement('script');
    delete window.Plotly;
    library.textContent = document.getElementById('library').textContent;
    document.head.append(library);
    const {newPlot} = window.Plotly;
    for (const [call, drawn] of waiting) newPlot(...call).then(drawn);
  };
  // A page that nobody sees yet is never drawn.
  if (document.hidden) draw(); else requestAnimationFrame(() => setTimeout(draw));
});
