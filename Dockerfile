# tribofmu with the forming solver, the twin, all readers, reports and the workbench; torch, dask and test tools are left out.
#   docker build -t tribofmu . && docker run --rm -u "$(id -u):$(id -g)" -v "$PWD:/work" tribofmu diagnose --data data --model linear
# docs/installation.md: the workbench, and what was tried.
FROM python:3.11-slim AS wheel
WORKDIR /source
COPY . .
RUN pip install --no-cache-dir build && python -m build --wheel --outdir /dist .

FROM python:3.11-slim
COPY constraints.txt /tmp/constraints.txt
COPY --from=wheel /dist /dist
RUN pip install --no-cache-dir -c /tmp/constraints.txt "$(ls /dist/*.whl)[solvers,reports,cross,daq,app]" && rm -r /dist /tmp/constraints.txt
RUN useradd --create-home user
# Whoever runs it, also a user without a home, can write here.
ENV NUMBA_CACHE_DIR=/tmp/numba XDG_CACHE_HOME=/tmp/cache
USER user
WORKDIR /work
ENTRYPOINT ["tribofmu"]
CMD ["--help"]
