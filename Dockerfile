# Two images: `docker build .` makes the one that keeps point sets in folders, `docker build --target s3 .` the one that
# can keep them in an S3, too.
ARG PYTHON_IMAGE=python:3.13-slim

FROM ${PYTHON_IMAGE} AS wheels
# A private index, if there is one: --build-arg PIP_INDEX_URL=… (the hashes in the lock still decide what is accepted).
ARG PIP_INDEX_URL
ENV PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_NO_CACHE_DIR=1 PYTHONDONTWRITEBYTECODE=1
RUN command -v strip || { apt-get update && apt-get install --yes --no-install-recommends binutils; }
WORKDIR /src
RUN python -m venv /opt/tools
COPY requirements.lock ./
RUN /opt/tools/bin/pip download --quiet --no-deps --require-hashes --only-binary :all: -r requirements.lock -d /wheels
COPY pyproject.toml README.md LICENSE ./
COPY ipcore ipcore
COPY service service
RUN /opt/tools/bin/pip install --quiet --no-index --find-links /wheels setuptools \
    && /opt/tools/bin/pip wheel --quiet --no-deps --no-build-isolation --no-index --wheel-dir /wheels .
COPY deploy/image deploy/image

FROM wheels AS environment
RUN sh deploy/image/environment.sh "ipfit[otel]"

FROM wheels AS environment-s3
RUN sh deploy/image/environment.sh "ipfit[otel,s3]"

# Any user may run it: what is written goes to /data, which belongs to the group 0 as well, and to /tmp.
FROM ${PYTHON_IMAGE} AS service
ENV PATH=/opt/venv/bin:$PATH \
    PYTHONUNBUFFERED=1 \
    PYTHONPYCACHEPREFIX=/opt/venv/bytecode \
    IPFIT_HOST=0.0.0.0 \
    IPFIT_DATA_DIR=/data
RUN install -d -o 10001 -g 0 -m 0770 /data
VOLUME /data
USER 10001:0
WORKDIR /data
EXPOSE 8000
HEALTHCHECK --interval=10s --timeout=5s --start-period=30s CMD ["ipfit", "healthcheck"]
ENTRYPOINT ["ipfit"]
CMD ["serve"]

FROM service AS s3
COPY --from=environment-s3 /opt/venv /opt/venv

FROM service AS plain
COPY --from=environment /opt/venv /opt/venv
